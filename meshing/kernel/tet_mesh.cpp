// Slots, feature edges and renumbering of the kernel's mesh.
#include "meshing/kernel/tet_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace weft::meshing {
namespace {

/// The count is never raised beyond the capacity, not even for a moment: sweeps read it.
std::optional<std::uint32_t> take_slots(std::atomic<std::uint32_t>& next, std::uint32_t count,
                                        std::size_t capacity) {
  std::uint32_t first = next.load(std::memory_order_relaxed);
  do {
    if (std::size_t{first} + count > capacity) return std::nullopt;
  } while (!next.compare_exchange_weak(first, first + count, std::memory_order_relaxed));
  return first;
}

std::uint32_t granted(std::optional<std::uint32_t> first, std::size_t capacity, const char* what) {
  if (!first)
    throw std::length_error("the mesh has room for " + std::to_string(capacity) + " " + what + " only");
  return *first;
}

/// Puts elements of arrays to new places: element i to place map[i]; what has no place is dropped. Takes no
/// memory but `scratch`, which has room for new_size elements.
template <class Id>
class Permutation {
 public:
  Permutation(const std::vector<Id>& old_to_new, std::uint32_t new_size, std::byte* scratch)
      : map_(old_to_new), new_size_(new_size), scratch_(scratch) {}

  /// One member of an array's elements.
  template <class T, class Member>
  void move_member(StableArray<T>& array, const Member& member) const {
    const auto* moved = moved_members(array, member);
    tbb::parallel_for(std::uint32_t{0}, new_size_, [&](std::uint32_t i) { member(array[i]) = moved[i]; });
  }

  template <class T>
  void move(StableArray<T>& array) const {
    move_member(array, [](T& x) -> T& { return x; });
    array.clear_from(new_size_, map_.size());
  }

  /// The same for elements most of which are zero: pages of a large array with no others take no memory
  /// afterwards.
  template <class T>
  void move_sparse(StableArray<T>& array) const {
    constexpr std::size_t kLarge = std::size_t{1} << 22;  // bytes
    const T* moved = moved_members(array, [](T& x) -> T& { return x; });
    const bool is_large = map_.size() * sizeof(T) >= kLarge;
    array.clear_from(is_large ? 0 : new_size_, map_.size());
    tbb::parallel_for(std::uint32_t{0}, new_size_, [&](std::uint32_t i) {
      const T there = is_large ? T{} : array[i];  // to read a page that has gone makes one
      if (there != moved[i]) array[i] = moved[i];
    });
  }

 private:
  /// In the new order, in the scratch.
  template <class T, class Member>
  auto* moved_members(StableArray<T>& array, const Member& member) const {
    using Value = std::remove_cvref_t<decltype(member(array[0]))>;
    static_assert(std::is_trivially_copyable_v<Value> && alignof(Value) <= alignof(std::max_align_t));
    const auto moved = reinterpret_cast<Value*>(scratch_);
    tbb::parallel_for(std::size_t{0}, map_.size(), [&](std::size_t i) {
      if (map_[i].valid()) moved[map_[i].value] = member(array[i]);
    });
    return moved;
  }

  const std::vector<Id>& map_;
  const std::uint32_t new_size_;
  std::byte* const scratch_;
};

}  // namespace

TetMesh::TetMesh(std::size_t vertex_capacity, std::size_t tet_capacity, Pages pages)
    : tets_(tet_capacity, pages),
      patches_(tet_capacity, Pages::small),  // most stay zero, which costs no memory then
      tet_refs_(tet_capacity, pages),
      quality_(tet_capacity, pages),
      marks_(tet_capacity, pages),
      vertices_(vertex_capacity, pages),
      vertex_marks_(vertex_capacity, pages),
      vertex_refs_(vertex_capacity, pages),
      labels_(vertex_capacity, pages),
      background_hints_(vertex_capacity, pages),
      surface_hints_(vertex_capacity, pages),
      claims_(vertex_capacity, pages) {}

std::optional<std::uint32_t> TetMesh::try_take_vertex_slots(std::uint32_t count) {
  const auto first = take_slots(vertex_slots_, count, vertex_capacity());
  if (!first) is_full_.store(true, std::memory_order_relaxed);
  return first;
}

std::optional<std::uint32_t> TetMesh::try_take_tet_slots(std::uint32_t count) {
  const auto first = take_slots(tet_slots_, count, tet_capacity());
  if (!first) is_full_.store(true, std::memory_order_relaxed);
  return first;
}

std::uint32_t TetMesh::take_vertex_slots(std::uint32_t count) {
  return granted(try_take_vertex_slots(count), vertex_capacity(), "vertices");
}

std::uint32_t TetMesh::take_tet_slots(std::uint32_t count) {
  return granted(try_take_tet_slots(count), tet_capacity(), "tets");
}

void TetMesh::reserve(Room room) {
  const Room before{vertex_capacity(), tet_capacity()};
  try {
    set_capacities({std::max(room.vertices, before.vertices), std::max(room.tets, before.tets)});
  } catch (const NoAddressSpace&) {
    set_capacities(before);  // what has grown would stand in the way of others
    throw;
  }
  is_full_.store(false, std::memory_order_relaxed);
}

void TetMesh::set_capacities(Room room) {
  const auto set = [](std::size_t capacity, auto&... arrays) { (arrays.set_capacity(capacity), ...); };
  set(room.tets, tets_, patches_, tet_refs_, quality_, marks_);
  set(room.vertices, vertices_, vertex_marks_, vertex_refs_, labels_, background_hints_, surface_hints_,
      claims_);
}

bool TetMesh::grow() {
  if (tet_capacity() >= kMostTets) return false;
  for (const double factor : {4.0, 2.0, 1.25}) {
    const auto more = [&](std::size_t n) {
      return std::min(kMostTets, static_cast<std::size_t>(factor * static_cast<double>(n)) + 100);
    };
    try {
      reserve({more(vertex_capacity()), more(tet_capacity())});
      return true;
    } catch (const NoAddressSpace&) {
    }
  }
  return false;
}

std::unique_ptr<TetMesh> reserve_tet_mesh(Room wanted, Room least, Pages pages) {
  for (;;) {
    try {
      return std::make_unique<TetMesh>(wanted.vertices, wanted.tets, pages);
    } catch (const NoAddressSpace&) {
      if (wanted.vertices <= least.vertices && wanted.tets <= least.tets) throw;
      wanted = {std::max(wanted.vertices / 2, least.vertices), std::max(wanted.tets / 2, least.tets)};
    }
  }
}

CurveId TetMesh::listed_curve(VertexId a, VertexId b) const {
  decltype(curves_)::const_accessor found;
  return curves_.find(found, edge_key(a, b)) ? CurveId(found->second) : CurveId();
}

void TetMesh::set_curve(VertexId a, VertexId b, CurveId c) {
  if (!c.valid()) {
    curves_.erase(edge_key(a, b));
    return;
  }
  decltype(curves_)::accessor place;
  curves_.insert(place, edge_key(a, b));
  place->second = c.value;
}

void TetMesh::divide_curve(VertexId a, VertexId p, VertexId b, CurveId c) {
  set_curve(a, p, c);
  try {
    set_curve(p, b, c);
  } catch (...) {
    set_curve(a, p, CurveId());
    throw;
  }
  set_curve(a, b, CurveId());
}

std::vector<TetMesh::FeatureEdge> TetMesh::feature_edges() const {
  std::vector<FeatureEdge> edges;
  edges.reserve(curves_.size());
  for (const auto& [key, curve] : curves_)
    edges.push_back({VertexId(static_cast<std::uint32_t>(key >> 32)),
                     VertexId(static_cast<std::uint32_t>(key)), CurveId(curve)});
  std::sort(edges.begin(), edges.end(),
            [](const auto& l, const auto& r) { return std::pair(l.a, l.b) < std::pair(r.a, r.b); });
  return edges;
}

void TetMesh::renumber(const std::vector<VertexId>& new_vertex, std::uint32_t num_vertices,
                       const std::vector<TetId>& new_tet, std::uint32_t num_tets) {
  // Large elements by their members: a copy of the whole array would be the peak of the whole run's memory.
  // All memory is taken before anything moves, so that an allocation that fails changes nothing.
  constexpr std::size_t kOfTet = sizeof(Tet::v);
  constexpr std::size_t kOfVertex = std::max({sizeof(VertexHead), sizeof(Metric), sizeof(LogMetric)});
  const auto scratch =
      std::make_unique_for_overwrite<std::byte[]>(std::max(num_tets * kOfTet, num_vertices * kOfVertex));
  const Permutation to_tets(new_tet, num_tets, scratch.get());
  const Permutation to_vertices(new_vertex, num_vertices, scratch.get());
  decltype(curves_) curves;
  for (const auto& [key, curve] : curves_)
    curves.emplace(edge_key(new_vertex[key >> 32], new_vertex[static_cast<std::uint32_t>(key)]), curve);
  tbb::parallel_for(0u, tet_slots(), [&](std::uint32_t i) {
    if (!alive(TetId(i))) return;
    Tet& t = tets_[i];
    for (std::uint32_t& v : t.v) v = new_vertex[v].value;
    for (std::uint32_t& n : t.n)
      if (n != TetFace().code) n = TetFace(new_tet[n >> 2], static_cast<int>(n & 3)).code;
  });
  tbb::parallel_for(0u, vertex_slots(), [&](std::uint32_t i) {
    if (std::uint32_t& t = vertices_[i].tet; t != 0) t = new_tet[t - 1].value + 1;
  });
  to_tets.move_member(tets_, [](Tet& t) -> std::array<std::uint32_t, 4>& { return t.v; });
  to_tets.move_member(tets_, [](Tet& t) -> std::array<std::uint32_t, 4>& { return t.n; });
  tets_.clear_from(num_tets, tet_slots());
  to_tets.move_sparse(patches_);
  to_tets.move(tet_refs_);
  to_tets.move(quality_);
  to_tets.move(marks_);
  to_vertices.move_member(vertices_, [](Vertex& v) -> VertexHead& { return v; });
  to_vertices.move_member(vertices_, [](Vertex& v) -> Metric& { return v.metric; });
  to_vertices.move_member(vertices_, [](Vertex& v) -> LogMetric& { return v.log_metric; });
  vertices_.clear_from(num_vertices, vertex_slots());
  to_vertices.move(vertex_marks_);
  to_vertices.move(vertex_refs_);
  to_vertices.move(labels_);
  to_vertices.move(background_hints_);
  to_vertices.move(surface_hints_);
  to_vertices.move(claims_);
  vertex_slots_ = num_vertices;
  tet_slots_ = num_tets;
  curves_.swap(curves);
}

}  // namespace weft::meshing
