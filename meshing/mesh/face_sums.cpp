// One look at each tet. Shares no code with what builds and adapts meshes.
#include "meshing/mesh/face_sums.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

constexpr std::size_t kTetsPerChunk = 1 << 14;

/// Steele, Lea and Flood's finaliser (OOPSLA 2014): every bit depends on every bit.
std::uint64_t mix(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ x >> 27) * 0x94D049BB133111EBull;
  return x ^ x >> 31;
}

std::uint64_t hash_of(std::uint64_t id) { return mix(id + 0x9E3779B97F4A7C15ull); }

Triangle ascending(Triangle v) {
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  if (v[1] > v[2]) std::swap(v[1], v[2]);
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  return v;
}

/// On which side of its face opposite vertex `f` a tet lies, by the numbers of the face's vertices.
template <class Number>
bool is_positive_side(Number a, Number b, Number c, std::size_t f) {
  return (a > b) ^ (b > c) ^ (a > c) ^ (f % 2 == 0);
}

/// The triangles by their vertices, and on which sides of each there is a tet.
class Triangles {
 public:
  Triangles(const std::vector<Triangle>& triangles, std::size_t num_points)
      : on_triangle_(num_points, 0), seen_(triangles.size(), 0) {
    std::size_t size = 16;
    while (size < 2 * triangles.size()) size *= 2;
    places_.assign(size, kNone);
    vertices_.reserve(triangles.size());
    for (const Triangle& triangle : triangles) add(ascending(triangle), num_points);
  }

  std::uint64_t faults() const {
    return static_cast<std::uint64_t>(std::ranges::count_if(seen_, [](std::uint32_t sides) {
      return sides != kPositive && sides != kNegative && sides != kPositive + kNegative;
    }));
  }

  std::vector<std::uint8_t> outer() const {
    std::vector<std::uint8_t> flags;
    flags.reserve(seen_.size());
    for (const std::uint32_t sides : seen_) flags.push_back(sides == kPositive || sides == kNegative);
    return flags;
  }

  /// Whether the face has a triangle, which then is told that a tet lies on that side. By any thread.
  bool see(const Triangle& face, bool positive) {
    if (!(on_triangle_[face[0]] & on_triangle_[face[1]] & on_triangle_[face[2]])) return false;
    const std::uint32_t found = places_[place_of(ascending(face))];
    if (found == kNone) return false;
    std::atomic_ref(seen_[found]).fetch_add(positive ? kPositive : kNegative, std::memory_order_relaxed);
    return true;
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint32_t kPositive = 1, kNegative = 1 << 16;

  void add(const Triangle& v, std::size_t num_points) {
    vertices_.push_back(v);
    const auto number = static_cast<std::uint32_t>(vertices_.size() - 1);
    if (v[2] >= num_points) return;  // no tet will be found at it
    std::uint32_t& place = places_[place_of(v)];
    if (place != kNone) return;  // given twice: likewise
    place = number;
    for (const std::uint32_t p : v) on_triangle_[p] = 1;
  }

  /// Where it is, or is to be put.
  std::size_t place_of(const Triangle& v) const {
    const std::size_t mask = places_.size() - 1;
    std::size_t place = mix(mix(std::uint64_t{v[0]} << 32 | v[1]) + v[2]) & mask;
    while (places_[place] != kNone && vertices_[places_[place]] != v) place = (place + 1) & mask;
    return place;
  }

  std::vector<std::uint8_t> on_triangle_;  ///< by point; bytes, since threads read them
  std::vector<std::uint32_t> seen_;        ///< by triangle: tets on each side
  std::vector<Triangle> vertices_;         ///< ascending
  std::vector<std::uint32_t> places_;      ///< open addressing
};

class Sum {
 public:
  Sum(const MeshData& mesh, std::span<const std::uint64_t> ids)
      : mesh_(mesh), ids_(ids), triangles_(mesh.triangles, mesh.points.size()) {}

  std::vector<std::uint8_t> outer() const { return triangles_.outer(); }

  FaceSums run() {
    FaceSums sums;
    sums.faults += mesh_.tet_refs.size() != mesh_.tets.size();
    if (sums.faults > 0) return sums;
    std::vector<FaceSums> parts((mesh_.tets.size() + kTetsPerChunk - 1) / kTetsPerChunk);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t chunk) {
      const std::size_t end = std::min(mesh_.tets.size(), (chunk + 1) * kTetsPerChunk);
      for (std::size_t t = chunk * kTetsPerChunk; t < end; ++t) add_tet(t, parts[chunk]);
    });
    for (const FaceSums& part : parts) sums += part;
    sums.faults += triangles_.faults();
    for (const Point& p : mesh_.points) sums.faults += !is_finite(p);
    return sums;
  }

 private:
  std::uint64_t id_of(std::uint32_t point) const { return ids_.empty() ? point : ids_[point]; }

  void add_tet(std::size_t t, FaceSums& sums) {
    const Tet& v = mesh_.tets[t];
    const auto& p = mesh_.points;
    if (*std::ranges::max_element(v) >= p.size() || orientation(p[v[0]], p[v[1]], p[v[2]], p[v[3]]) <= 0) {
      ++sums.faults;
      return;
    }
    std::array<std::uint64_t, 4> id, hash;
    for (std::size_t i = 0; i < 4; ++i) hash[i] = hash_of(id[i] = id_of(v[i]));
    const std::uint64_t all = hash[0] + hash[1] + hash[2] + hash[3];
    const std::uint64_t reference = hash_of(static_cast<std::uint32_t>(mesh_.tet_refs[t]));
    for (std::size_t f = 0; f < 4; ++f) {
      const std::size_t i = (f + 1) % 4, j = (f + 2) % 4, k = (f + 3) % 4;
      const bool positive = is_positive_side(id[i], id[j], id[k], f);
      if (triangles_.see({v[i], v[j], v[k]}, positive)) continue;
      const std::uint64_t face = mix(all - hash[f]);
      const std::uint64_t signed_face = positive ? face : std::uint64_t{0} - face;
      sums.faces += signed_face;
      sums.references += signed_face * reference;
    }
  }

  const MeshData& mesh_;
  const std::span<const std::uint64_t> ids_;
  Triangles triangles_;
};

}  // namespace

FaceSums& FaceSums::operator+=(const FaceSums& other) {
  faults += other.faults;
  faces += other.faces;
  references += other.references;
  return *this;
}

FaceSums sum_faces(const MeshData& mesh, std::span<const std::uint64_t> ids,
                   std::vector<std::uint8_t>* outer) {
  Sum sum(mesh, ids);
  const FaceSums sums = sum.run();
  if (outer) *outer = sum.outer();
  return sums;
}

/// Sides of faces at their least vertex, the two others and the orientation in a number.
std::uint64_t crowded_sides(const MeshData& mesh) {
  const auto for_sides = [&](const auto& visit) {
    for (const Tet& v : mesh.tets)
      for (std::size_t f = 0; f < 4; ++f) {
        const Triangle face = {v[(f + 1) % 4], v[(f + 2) % 4], v[(f + 3) % 4]}, sorted = ascending(face);
        const bool positive = is_positive_side(face[0], face[1], face[2], f);
        visit(sorted[0], std::uint64_t{sorted[1]} << 33 | std::uint64_t{sorted[2]} << 1 | positive);
      }
  };
  std::vector<std::size_t> begin(mesh.points.size() + 2, 0);
  for_sides([&](std::uint32_t least, std::uint64_t) { ++begin[least + 2]; });
  for (std::size_t v = 2; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<std::uint64_t> sides(4 * mesh.tets.size());
  for_sides([&](std::uint32_t least, std::uint64_t side) { sides[begin[least + 1]++] = side; });
  std::atomic<std::uint64_t> crowded = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.points.size(), 1024), [&](const auto& range) {
    std::uint64_t found = 0;
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      const auto first = sides.begin() + static_cast<std::ptrdiff_t>(begin[v]),
                 last = sides.begin() + static_cast<std::ptrdiff_t>(begin[v + 1]);
      std::sort(first, last);
      for (auto side = first; side != last && side + 1 != last; ++side) found += *side == *(side + 1);
    }
    crowded += found;
  });
  return crowded;
}

}  // namespace weft::meshing
