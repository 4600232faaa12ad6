// Slots, feature edges and renumbering of the kernel's mesh.
#include "meshing/kernel/tet_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
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

/// Permutes one member of an array's elements: that of element i goes to element map[i].
template <class T, class Id, class Member>
void permute_member(StableArray<T>& array, const std::vector<Id>& old_to_new, std::uint32_t new_size,
                    const Member& member) {
  std::vector<std::remove_cvref_t<decltype(member(array[0]))>> moved(new_size);
  tbb::parallel_for(std::size_t{0}, old_to_new.size(), [&](std::size_t i) {
    if (old_to_new[i].valid()) moved[old_to_new[i].value] = member(array[i]);
  });
  tbb::parallel_for(std::size_t{0}, moved.size(), [&](std::size_t i) { member(array[i]) = moved[i]; });
}

/// Permutes one array: element i goes to map[i]; what has no new place is dropped.
template <class T, class Id>
void permute(StableArray<T>& array, const std::vector<Id>& old_to_new, std::uint32_t new_size) {
  permute_member(array, old_to_new, new_size, [](T& x) -> T& { return x; });
  array.release_from(new_size);
}

}  // namespace

TetMesh::TetMesh(std::size_t vertex_capacity, std::size_t tet_capacity, Pages pages)
    : tets_(tet_capacity, pages),
      patches_(tet_capacity, pages),
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

CurveId TetMesh::curve(VertexId a, VertexId b) const {
  if (std::min(kind(a), kind(b)) < VertexKind::ridge)
    return {};  // only ridge vertices and corners; the table is slow
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
  const std::vector<FeatureEdge> features = feature_edges();
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
  // Large elements by their members: a copy of the whole array would be the peak of the whole run's memory.
  permute_member(tets_, new_tet, num_tets, [](Tet& t) -> std::array<std::uint32_t, 4>& { return t.v; });
  permute_member(tets_, new_tet, num_tets, [](Tet& t) -> std::array<std::uint32_t, 4>& { return t.n; });
  tets_.release_from(num_tets);
  permute(patches_, new_tet, num_tets);
  permute(tet_refs_, new_tet, num_tets);
  permute(quality_, new_tet, num_tets);
  permute(marks_, new_tet, num_tets);
  permute_member(vertices_, new_vertex, num_vertices, [](Vertex& v) -> VertexHead& { return v; });
  permute_member(vertices_, new_vertex, num_vertices, [](Vertex& v) -> Metric& { return v.metric; });
  permute_member(vertices_, new_vertex, num_vertices, [](Vertex& v) -> LogMetric& { return v.log_metric; });
  vertices_.release_from(num_vertices);
  permute(vertex_marks_, new_vertex, num_vertices);
  permute(vertex_refs_, new_vertex, num_vertices);
  permute(labels_, new_vertex, num_vertices);
  permute(background_hints_, new_vertex, num_vertices);
  permute(surface_hints_, new_vertex, num_vertices);
  permute(claims_, new_vertex, num_vertices);
  vertex_slots_ = num_vertices;
  tet_slots_ = num_tets;
  curves_.clear();
  for (const FeatureEdge& e : features) set_curve(new_vertex[e.a.value], new_vertex[e.b.value], e.curve);
}

}  // namespace weft::meshing
