// The steps of check_mesh() and of the checks of a mesh in parts: arrays, orientations and sums, one entity
// at a time; connectivity by sorting all face records of the tets and walking through the groups of equal
// faces. Shares no code with the other connectivity sources on purpose, since it judges what they help to
// build.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/compensated_sum.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/problems.h"

namespace weft::meshing::checks {

inline constexpr std::size_t kChunk = 1 << 15;

inline std::size_t num_chunks(std::size_t n) { return (n + kChunk - 1) / kChunk; }

/// Runs body(chunk, begin, end) for fixed chunks of [0, n) in parallel: per-chunk results put together in
/// chunk order are the same for any number of threads.
template <class Body>
void for_chunks(std::size_t n, const Body& body) {
  tbb::parallel_for(std::size_t{0}, num_chunks(n),
                    [&](std::size_t c) { body(c, c * kChunk, std::min(n, (c + 1) * kChunk)); });
}

/// The same for a body(begin, end, problems) that finds problems.
template <class Body>
void find_in_chunks(std::size_t n, Problems& problems, const Body& body) {
  std::vector<Problems> found(num_chunks(n), problems.fresh());
  for_chunks(n, [&](std::size_t c, std::size_t begin, std::size_t end) { body(begin, end, found[c]); });
  for (Problems& f : found) problems.append(std::move(f));
}

template <std::size_t N>
void check_vertices(const char* entity, const std::vector<std::array<std::uint32_t, N>>& entities,
                    std::size_t num_points, Problems& problems, std::uint64_t passed = 0,
                    bool may_collapse = false) {
  find_in_chunks(entities.size(), problems, [&](std::size_t begin, std::size_t end, Problems& found) {
    for (std::size_t e = begin; e < end; ++e) {
      auto v = entities[e];
      std::sort(v.begin(), v.end());
      if (v[N - 1] >= num_points)
        found.add(entity, ' ', passed + e + 1, ": vertex ", std::uint64_t{v[N - 1]} + 1, " is out of range (",
                  num_points, " points)");
      if (const auto twice = std::adjacent_find(v.begin(), v.end()); twice != v.end() && !may_collapse)
        found.add(entity, ' ', passed + e + 1, ": vertex ", std::uint64_t{*twice} + 1, " appears twice");
    }
  });
}

inline void check_references(const char* entity, std::size_t num_refs, std::size_t num_entities,
                             Problems& problems) {
  if (num_refs != num_entities)
    problems.add(entity, " references: ", num_refs, " given for ", num_entities, " entities");
}

inline void check_list(const char* list, const std::vector<std::uint32_t>& indices, std::size_t limit,
                       Problems& problems, std::uint64_t passed = 0) {
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= limit)
      problems.add(list, ' ', passed + i + 1, ": index ", std::uint64_t{indices[i]} + 1, " is out of range (",
                   limit, " entities)");
}

inline void check_coordinates(const std::vector<Point>& points, Problems& problems,
                              std::uint64_t passed = 0) {
  for (std::size_t p = 0; p < points.size(); ++p)
    if (!is_finite(points[p])) problems.add("vertex ", passed + p + 1, ": a coordinate is not finite");
}

/// The sign of a tet's orientation; one that is not positive is a problem of the tet with this number.
inline std::int8_t check_orientation(std::uint64_t number, const std::array<Point, 4>& p,
                                     Problems& problems) {
  const auto sign = static_cast<std::int8_t>(orientation(p[0], p[1], p[2], p[3]));
  if (sign < 0) problems.add("tet ", number + 1, ": inverted (its orientation is negative)");
  if (sign == 0) problems.add("tet ", number + 1, ": flat (its orientation is zero)");
  return sign;
}

using SumsByRef = std::map<std::int32_t, CompensatedSum>;

inline void add(const CompensatedSum& part, CompensatedSum& sum) {
  sum.add(part.sum);
  sum.add(part.lost);
}

/// size(i) of entity i, by its reference.
template <class Size>
SumsByRef sum_by_ref(const std::vector<std::int32_t>& refs, const Size& size) {
  std::vector<SumsByRef> parts(num_chunks(refs.size()));
  for_chunks(refs.size(), [&](std::size_t c, std::size_t begin, std::size_t end) {
    auto part = parts[c].end();  // neighbours mostly have the same reference
    for (std::size_t e = begin; e < end; ++e) {
      if (part == parts[c].end() || part->first != refs[e]) part = parts[c].try_emplace(refs[e]).first;
      part->second.add(size(e));
    }
  });
  SumsByRef sums;
  for (const SumsByRef& part : parts)
    for (const auto& [ref, sum] : part) add(sum, sums[ref]);
  return sums;
}

inline std::map<std::int32_t, double> values_of(const SumsByRef& sums) {
  std::map<std::int32_t, double> values;
  for (const auto& [ref, sum] : sums) values[ref] = sum.value();
  return values;
}

inline double volume_of(const std::array<Point, 4>& p) { return six_volume(p[0], p[1], p[2], p[3]) / 6; }
inline double area_of(const std::array<Point, 3>& p) { return norm(cross(p[1] - p[0], p[2] - p[0])) / 2; }

/// Volumes by reference, and their sum.
inline void put_volumes(const SumsByRef& sums, CheckReport& report) {
  report.volume_by_ref = values_of(sums);
  CompensatedSum volume;
  for (const auto& [ref, part] : report.volume_by_ref) volume.add(part);
  report.volume = volume.value();
}

/// Three vertices, ascending, and where they occur: tet * 4 + face, or a triangle. Two words compare faster
/// than four halves.
struct FaceRecord {
  std::uint64_t high, low;
  FaceRecord() = default;
  FaceRecord(Triangle v, std::uint32_t place) {
    std::sort(v.begin(), v.end());
    high = std::uint64_t{v[0]} << 32 | v[1];
    low = std::uint64_t{v[2]} << 32 | place;
  }
  Triangle vertices() const {
    return {static_cast<std::uint32_t>(high >> 32), static_cast<std::uint32_t>(high),
            static_cast<std::uint32_t>(low >> 32)};
  }
  std::uint32_t place() const { return static_cast<std::uint32_t>(low); }
  std::uint32_t tet() const { return place() / 4; }
  std::uint32_t face() const { return place() % 4; }
  bool same_face(const FaceRecord& o) const { return high == o.high && low >> 32 == o.low >> 32; }
  bool operator<(const FaceRecord& o) const { return high != o.high ? high < o.high : low < o.low; }
};

inline std::string name(const FaceRecord& face) {
  std::ostringstream out;
  const Triangle v = face.vertices();
  out << "face (" << std::uint64_t{v[0]} + 1 << ' ' << std::uint64_t{v[1]} + 1 << ' '
      << std::uint64_t{v[2]} + 1 << ')';
  return out.str();
}

inline std::vector<FaceRecord> sorted_tet_faces(const std::vector<Tet>& tets) {
  std::vector<FaceRecord> faces(4 * tets.size());
  for_chunks(tets.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      for (std::size_t f = 0; f < 4; ++f) {
        const Tet& v = tets[t];
        faces[4 * t + f] = {{v[(f + 1) % 4], v[(f + 2) % 4], v[(f + 3) % 4]},
                            static_cast<std::uint32_t>(4 * t + f)};
      }
  });
  tbb::parallel_sort(faces);
  return faces;
}

inline std::vector<FaceRecord> sorted_triangles(const std::vector<Triangle>& triangles) {
  std::vector<FaceRecord> records(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    records[i] = {triangles[i], static_cast<std::uint32_t>(i)};
  tbb::parallel_sort(records);
  return records;
}

inline void report_no_face(std::uint64_t triangle, Problems& problems) {
  problems.add("triangle ", triangle + 1, ": is not a face of any tet");
}
inline void report_repeated(std::uint64_t triangle, std::uint64_t next, Problems& problems) {
  problems.add("triangles ", triangle + 1, " and ", next + 1, ": have the same vertices");
}
inline void report_no_edge(std::uint64_t edge, Problems& problems) {
  problems.add("edge ", edge + 1, ": is not an edge of any tet or triangle");
}

/// Triangles, sorted, of which some are not marked as faces or have the same vertices.
inline void report_triangles(const std::vector<FaceRecord>& triangles, std::span<const std::uint8_t> matched,
                             Problems& problems) {
  for (std::size_t i = 0; i < matched.size(); ++i)
    if (!matched[i]) report_no_face(i, problems);
  for (std::size_t i = 1; i < triangles.size(); ++i)
    if (triangles[i].same_face(triangles[i - 1]))
      report_repeated(triangles[i - 1].place(), triangles[i].place(), problems);
}

/// Sets of tets connected through faces: lock-free union-find. Larger roots are linked to smaller ones, so
/// that the result does not depend on the order of the links.
class Components {
 public:
  explicit Components(std::size_t n) : parents_(n) {
    for (std::size_t i = 0; i < n; ++i) parents_[i] = static_cast<std::uint32_t>(i);
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = root(a), b = root(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      // Fails when another thread has linked `a` since it was seen to be a root: look again.
      std::uint32_t expected = a;
      if (std::atomic_ref(parents_[a]).compare_exchange_strong(expected, b)) return;
    }
  }
  std::uint64_t count() const {
    return count([](std::uint32_t) { return true; });
  }
  /// Sets whose root, which is their least, is counted.
  template <class Counts>
  std::uint64_t count(const Counts& counts) const {
    std::uint64_t roots = 0;
    for (std::uint32_t i = 0; i < parents_.size(); ++i) roots += parents_[i] == i && counts(i);
    return roots;
  }
  std::uint32_t root(std::uint32_t i) {
    for (;;) {
      std::atomic_ref link(parents_[i]);
      std::uint32_t parent = link.load(std::memory_order_relaxed);
      const std::uint32_t grandparent = std::atomic_ref(parents_[parent]).load(std::memory_order_relaxed);
      if (parent == grandparent) return parent;
      link.compare_exchange_weak(parent, grandparent, std::memory_order_relaxed);
      i = grandparent;
    }
  }

 private:
  std::vector<std::uint32_t> parents_;
};

/// Of a mesh in parts: all tets at the vertices of a range are here. Faces, edges and vertices belong to the
/// part in whose range their least vertex is.
struct StarsRange {
  std::span<const std::uint64_t> tet_numbers =
      {};  ///< in the whole mesh, ascending; empty: all tets are here
  std::uint32_t first = 0, end = std::numeric_limits<std::uint32_t>::max();  ///< vertices
};

/// Walks the groups of equal faces of tets beside the sorted triangles.
class FaceCheck {
 public:
  FaceCheck(const MeshData& mesh, std::span<const std::int8_t> signs, const StarsRange& range = {})
      : mesh_(mesh),
        signs_(signs),
        range_(range),
        faces_(sorted_tet_faces(mesh.tets)),
        triangles_(sorted_triangles(mesh.triangles)),
        matched_(mesh.triangles.size(), 0),
        components_(mesh.tets.size()) {}

  void run(Problems& problems) {
    find_in_chunks(faces_.size(), problems, [&](std::size_t begin, std::size_t end, Problems& found) {
      check_groups(begin, end, found);
    });
  }
  std::uint64_t num_components() const { return components_.count(); }
  Components& components() { return components_; }
  /// Triangles that are faces.
  const std::vector<std::uint8_t>& matched() const { return matched_; }
  const std::vector<FaceRecord>& triangles() const { return triangles_; }

  std::uint64_t count_touching_edges() const {
    std::vector<std::uint64_t> edges;
    for_groups([&](Group group) {
      if (group.size() != 1) return;
      const Triangle v = group[0].vertices();  // ascending
      for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}})
        if (owns(v[static_cast<std::size_t>(i)]))
          edges.push_back(std::uint64_t{v[static_cast<std::size_t>(i)]} << 32 |
                          v[static_cast<std::size_t>(j)]);
    });
    tbb::parallel_sort(edges);
    std::uint64_t touching = 0;
    for (std::size_t i = 0, next = 0; i < edges.size(); i = next) {
      while (next < edges.size() && edges[next] == edges[i]) ++next;
      touching += next - i != 2;
    }
    return touching;
  }

  /// Sets of corners of tets that are joined around their vertex: one for each vertex where the mesh is a
  /// manifold.
  std::uint64_t count_balls() const {
    Components corners(4 * mesh_.tets.size());
    for_groups([&](Group group) {
      for (const FaceRecord& face : group.subspan(1))
        for (const std::uint32_t v : face.vertices())
          corners.unite(corner_of(group[0].tet(), v), corner_of(face.tet(), v));
    });
    return corners.count([&](std::uint32_t corner) { return owns(mesh_.tets[corner / 4][corner % 4]); });
  }

 private:
  using Group = std::span<const FaceRecord>;

  bool owns(std::uint32_t vertex) const { return vertex >= range_.first && vertex < range_.end; }
  /// For people: from 1.
  std::uint64_t named(std::uint32_t tet) const {
    return (range_.tet_numbers.empty() ? tet : range_.tet_numbers[tet]) + 1;
  }

  template <class Visit>
  void for_groups(const Visit& visit) const {
    for (std::size_t i = 0, next = 0; i < faces_.size(); i = next) {
      while (next < faces_.size() && faces_[next].same_face(faces_[i])) ++next;
      visit(Group(&faces_[i], next - i));
    }
  }

  std::uint32_t corner_of(std::uint32_t tet, std::uint32_t vertex) const {
    const auto at = std::ranges::find(mesh_.tets[tet], vertex) - mesh_.tets[tet].begin();
    return 4 * tet + static_cast<std::uint32_t>(at);
  }

  /// The groups that start in [begin, end).
  void check_groups(std::size_t begin, std::size_t end, Problems& found) {
    while (begin > 0 && begin < end && faces_[begin].same_face(faces_[begin - 1])) ++begin;
    if (begin >= end) return;
    auto triangle = std::lower_bound(triangles_.begin(), triangles_.end(), first_of(faces_[begin]));
    while (begin < end) {
      std::size_t next = begin + 1;
      while (next < faces_.size() && faces_[next].same_face(faces_[begin])) ++next;
      while (triangle != triangles_.end() && *triangle < first_of(faces_[begin])) ++triangle;
      bool has_triangle = false;
      for (; triangle != triangles_.end() && triangle->same_face(faces_[begin]); ++triangle) {
        matched_[triangle->place()] = 1;
        has_triangle = true;
      }
      const Group group(&faces_[begin], next - begin);
      for (const FaceRecord& face : group.subspan(1)) components_.unite(group[0].tet(), face.tet());
      if (owns(faces_[begin].vertices()[0])) {
        check_tets(group, found);
        if (!has_triangle) check_needs_no_triangle(group, found);
      }
      begin = next;
    }
  }

  /// The smallest record of the same face.
  static FaceRecord first_of(FaceRecord face) {
    face.low &= ~std::uint64_t{0xFFFFFFFFu};
    return face;
  }

  std::uint32_t opposite(const FaceRecord& face) const { return mesh_.tets[face.tet()][face.face()]; }

  /// On which side of the face, its vertices ascending, the tet lies: its orientation, and the sign of the
  /// permutation that leads from the tet's order of vertices to (face, opposite vertex).
  int side(const FaceRecord& face) const {
    const Tet& v = mesh_.tets[face.tet()];
    const std::uint32_t f = face.face();
    const std::uint32_t a = v[(f + 1) % 4], b = v[(f + 2) % 4], c = v[(f + 3) % 4];
    const bool odd = (a > b) ^ (b > c) ^ (a > c) ^ (f % 2 == 0);
    return odd ? -signs_[face.tet()] : signs_[face.tet()];
  }

  void check_tets(Group group, Problems& found) {
    const std::size_t shown = std::min<std::size_t>(group.size(), 8);  // no quadratic time in absurd meshes
    if (group.size() > 2) {
      std::ostringstream tets;
      for (const FaceRecord& face : group.first(shown)) tets << ' ' << named(face.tet());
      found.add(name(group[0]), ": shared by ", group.size(), " tets:", tets.str());
    }
    for (std::size_t i = 0; i < shown; ++i)
      for (std::size_t j = i + 1; j < shown; ++j) check_pair(group[i], group[j], found);
  }

  void check_pair(const FaceRecord& a, const FaceRecord& b, Problems& found) const {
    if (opposite(a) == opposite(b)) {
      // The pair meets in four groups: named in that of the face without the largest vertex.
      if (opposite(a) > a.vertices()[2])
        found.add("tets ", named(a.tet()), " and ", named(b.tet()), ": have the same vertices");
    } else if (side(a) == side(b)) {
      found.add(name(a), ": tets ", named(a.tet()), " and ", named(b.tet()), " lie on the same side of it");
    }
  }

  void check_needs_no_triangle(Group group, Problems& found) const {
    if (group.size() == 1) {
      found.add(name(group[0]), " of tet ", named(group[0].tet()), ": on the boundary without a triangle");
      return;
    }
    const std::int32_t ref = mesh_.tet_refs[group[0].tet()];
    for (const FaceRecord& face : group.subspan(1)) {
      if (mesh_.tet_refs[face.tet()] == ref) continue;
      found.add(name(face), ": between tets ", named(group[0].tet()), " and ", named(face.tet()),
                " of different references without a triangle");
      return;
    }
  }

  const MeshData& mesh_;
  const std::span<const std::int8_t> signs_;
  const StarsRange range_;
  const std::vector<FaceRecord> faces_;
  const std::vector<FaceRecord> triangles_;
  std::vector<std::uint8_t> matched_;  // triangles that are faces; each is written by one chunk
  Components components_;
};

struct EdgeRecord {
  std::uint32_t a, b, index;
  friend auto operator<=>(const EdgeRecord&, const EdgeRecord&) = default;
};

/// The listed edges, with a mark on each that is an edge of some tet or triangle.
class EdgeCheck {
 public:
  explicit EdgeCheck(const MeshData& mesh) : found_(mesh.edges.size(), 0) {
    std::uint32_t greatest = 0;
    for (std::uint32_t e = 0; e < mesh.edges.size(); ++e) {
      const auto [a, b] = std::minmax(mesh.edges[e][0], mesh.edges[e][1]);
      records_.push_back({a, b, e});
      greatest = std::max(greatest, b);
    }
    is_end_.resize(records_.empty() ? 0 : std::size_t{greatest} + 1, 0);
    for (const EdgeRecord& edge : records_) is_end_[edge.a] = is_end_[edge.b] = 1;
    tbb::parallel_sort(records_);
  }

  template <std::size_t N>
  void mark(const std::vector<std::array<std::uint32_t, N>>& entities) {
    for_chunks(entities.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e)
        for (std::size_t i = 0; i < N; ++i)
          for (std::size_t j = i + 1; j < N; ++j) mark_edge(entities[e][i], entities[e][j]);
    });
  }
  const std::vector<std::uint8_t>& found() const { return found_; }
  static void report(std::span<const std::uint8_t> found, Problems& problems) {
    for (std::size_t e = 0; e < found.size(); ++e)
      if (!found[e]) report_no_edge(e, problems);
  }

 private:
  void mark_edge(std::uint32_t a, std::uint32_t b) {
    if (std::max(a, b) >= is_end_.size() || !is_end_[a] || !is_end_[b]) return;
    if (a > b) std::swap(a, b);
    auto it = std::lower_bound(records_.begin(), records_.end(), EdgeRecord{a, b, 0});
    for (; it != records_.end() && it->a == a && it->b == b; ++it)
      std::atomic_ref(found_[it->index]).store(1, std::memory_order_relaxed);
  }

  std::vector<EdgeRecord> records_;
  std::vector<std::uint8_t> found_;
  std::vector<std::uint8_t> is_end_;
};

}  // namespace weft::meshing::checks
