// The full check of a mesh: sorts all face records of the tets and walks through the groups of equal faces.
// Shares no code with the other connectivity sources on purpose, since it judges what they help to build.
#include "meshing/mesh/check_mesh.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <span>
#include <sstream>
#include <utility>

#include "meshing/base/compensated_sum.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/problems.h"

namespace weft::meshing {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Tet = std::array<std::uint32_t, 4>;

constexpr std::size_t kChunk = 1 << 15;

std::size_t num_chunks(std::size_t n) { return (n + kChunk - 1) / kChunk; }

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

// --- The arrays themselves
// -----------------------------------------------------------------------------------

template <std::size_t N>
void check_vertices(const char* entity, const std::vector<std::array<std::uint32_t, N>>& entities,
                    std::size_t num_points, Problems& problems) {
  find_in_chunks(entities.size(), problems, [&](std::size_t begin, std::size_t end, Problems& found) {
    for (std::size_t e = begin; e < end; ++e) {
      auto v = entities[e];
      std::sort(v.begin(), v.end());
      if (v[N - 1] >= num_points)
        found.add(entity, ' ', e + 1, ": vertex ", std::uint64_t{v[N - 1]} + 1, " is out of range (",
                  num_points, " points)");
      if (const auto twice = std::adjacent_find(v.begin(), v.end()); twice != v.end())
        found.add(entity, ' ', e + 1, ": vertex ", std::uint64_t{*twice} + 1, " appears twice");
    }
  });
}

void check_references(const char* entity, std::size_t num_refs, std::size_t num_entities,
                      Problems& problems) {
  if (num_refs != num_entities)
    problems.add(entity, " references: ", num_refs, " given for ", num_entities, " entities");
}

void check_list(const char* list, const std::vector<std::uint32_t>& indices, std::size_t limit,
                Problems& problems) {
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= limit)
      problems.add(list, ' ', i + 1, ": index ", std::uint64_t{indices[i]} + 1, " is out of range (", limit,
                   " entities)");
}

void check_coordinates(const std::vector<Point>& points, Problems& problems) {
  for (std::size_t p = 0; p < points.size(); ++p)
    if (!std::isfinite(points[p].x) || !std::isfinite(points[p].y) || !std::isfinite(points[p].z))
      problems.add("vertex ", p + 1, ": a coordinate is not finite");
}

// --- Tets, faces and triangles
// -------------------------------------------------------------------------------

/// Three vertices, ascending, and where they occur: tet * 4 + face, or a triangle. Two words compare faster
/// than four halves.
struct SortedFace {
  std::uint64_t high, low;
  SortedFace() = default;
  SortedFace(Triangle v, std::uint32_t place) {
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
  bool same_face(const SortedFace& o) const { return high == o.high && low >> 32 == o.low >> 32; }
  bool operator<(const SortedFace& o) const { return high != o.high ? high < o.high : low < o.low; }
};

std::string name(const SortedFace& face) {
  std::ostringstream out;
  const Triangle v = face.vertices();
  out << "face (" << std::uint64_t{v[0]} + 1 << ' ' << std::uint64_t{v[1]} + 1 << ' '
      << std::uint64_t{v[2]} + 1 << ')';
  return out.str();
}

std::vector<SortedFace> sorted_tet_faces(const std::vector<Tet>& tets) {
  std::vector<SortedFace> faces(4 * tets.size());
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

std::vector<SortedFace> sorted_faces(const std::vector<Triangle>& triangles) {
  std::vector<SortedFace> records(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    records[i] = {triangles[i], static_cast<std::uint32_t>(i)};
  tbb::parallel_sort(records);
  return records;
}

/// The sign of every tet's orientation; reports those that are not positive.
std::vector<std::int8_t> orientations(const MeshData& mesh, Problems& problems) {
  std::vector<std::int8_t> signs(mesh.tets.size());
  find_in_chunks(mesh.tets.size(), problems, [&](std::size_t begin, std::size_t end, Problems& found) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& [a, b, c, d] = mesh.tets[t];
      const auto& p = mesh.points;
      signs[t] = static_cast<std::int8_t>(orientation(p[a], p[b], p[c], p[d]));
      if (signs[t] < 0) found.add("tet ", t + 1, ": inverted (its orientation is negative)");
      if (signs[t] == 0) found.add("tet ", t + 1, ": flat (its orientation is zero)");
    }
  });
  return signs;
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
    std::uint64_t roots = 0;
    for (std::size_t i = 0; i < parents_.size(); ++i) roots += parents_[i] == i;
    return roots;
  }

 private:
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
  std::vector<std::uint32_t> parents_;
};

/// Walks the groups of equal faces of tets beside the sorted triangles.
class FaceCheck {
 public:
  FaceCheck(const MeshData& mesh, const std::vector<std::int8_t>& signs)
      : mesh_(mesh),
        signs_(signs),
        faces_(sorted_tet_faces(mesh.tets)),
        triangles_(sorted_faces(mesh.triangles)),
        matched_(mesh.triangles.size(), 0),
        components_(mesh.tets.size()) {}

  void run(Problems& problems) {
    find_in_chunks(faces_.size(), problems, [&](std::size_t begin, std::size_t end, Problems& found) {
      check_groups(begin, end, found);
    });
    check_triangles(problems);
  }
  std::uint64_t num_components() const { return components_.count(); }

  std::uint64_t count_touching_edges() const {
    std::vector<std::uint64_t> edges;
    for_groups([&](Group group) {
      if (group.size() != 1) return;
      const Triangle v = group[0].vertices();  // ascending
      for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}})
        edges.push_back(std::uint64_t{v[static_cast<std::size_t>(i)]} << 32 | v[static_cast<std::size_t>(j)]);
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
      for (const SortedFace& face : group.subspan(1))
        for (const std::uint32_t v : face.vertices())
          corners.unite(corner_of(group[0].tet(), v), corner_of(face.tet(), v));
    });
    return corners.count();
  }

 private:
  using Group = std::span<const SortedFace>;

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
      check_tets(group, found);
      if (!has_triangle) check_needs_no_triangle(group, found);
      begin = next;
    }
  }

  /// The smallest record of the same face.
  static SortedFace first_of(SortedFace face) {
    face.low &= ~std::uint64_t{0xFFFFFFFFu};
    return face;
  }

  std::uint32_t opposite(const SortedFace& face) const { return mesh_.tets[face.tet()][face.face()]; }

  /// On which side of the face, its vertices ascending, the tet lies: its orientation, and the sign of the
  /// permutation that leads from the tet's order of vertices to (face, opposite vertex).
  int side(const SortedFace& face) const {
    const Tet& v = mesh_.tets[face.tet()];
    const std::uint32_t f = face.face();
    const std::uint32_t a = v[(f + 1) % 4], b = v[(f + 2) % 4], c = v[(f + 3) % 4];
    const bool odd = (a > b) ^ (b > c) ^ (a > c) ^ (f % 2 == 0);
    return odd ? -signs_[face.tet()] : signs_[face.tet()];
  }

  void check_tets(Group group, Problems& found) {
    const std::size_t shown = std::min<std::size_t>(group.size(), 8);  // no quadratic time in absurd meshes
    for (std::size_t i = 1; i < group.size(); ++i) components_.unite(group[0].tet(), group[i].tet());
    if (group.size() > 2) {
      std::ostringstream tets;
      for (const SortedFace& face : group.first(shown)) tets << ' ' << face.tet() + 1;
      found.add(name(group[0]), ": shared by ", group.size(), " tets:", tets.str());
    }
    for (std::size_t i = 0; i < shown; ++i)
      for (std::size_t j = i + 1; j < shown; ++j) check_pair(group[i], group[j], found);
  }

  void check_pair(const SortedFace& a, const SortedFace& b, Problems& found) const {
    if (opposite(a) == opposite(b)) {
      // The pair meets in four groups: named in that of the face without the largest vertex.
      if (opposite(a) > a.vertices()[2])
        found.add("tets ", a.tet() + 1, " and ", b.tet() + 1, ": have the same vertices");
    } else if (side(a) == side(b)) {
      found.add(name(a), ": tets ", a.tet() + 1, " and ", b.tet() + 1, " lie on the same side of it");
    }
  }

  void check_needs_no_triangle(Group group, Problems& found) const {
    if (group.size() == 1) {
      found.add(name(group[0]), " of tet ", group[0].tet() + 1, ": on the boundary without a triangle");
      return;
    }
    const std::int32_t ref = mesh_.tet_refs[group[0].tet()];
    for (const SortedFace& face : group.subspan(1)) {
      if (mesh_.tet_refs[face.tet()] == ref) continue;
      found.add(name(face), ": between tets ", group[0].tet() + 1, " and ", face.tet() + 1,
                " of different references without a triangle");
      return;
    }
  }

  void check_triangles(Problems& problems) const {
    for (std::size_t i = 0; i < matched_.size(); ++i)
      if (!matched_[i]) problems.add("triangle ", i + 1, ": is not a face of any tet");
    for (std::size_t i = 1; i < triangles_.size(); ++i)
      if (triangles_[i].same_face(triangles_[i - 1]))
        problems.add("triangles ", triangles_[i - 1].place() + 1, " and ", triangles_[i].place() + 1,
                     ": have the same vertices");
  }

  const MeshData& mesh_;
  const std::vector<std::int8_t>& signs_;
  const std::vector<SortedFace> faces_;
  const std::vector<SortedFace> triangles_;
  std::vector<std::uint8_t> matched_;  // triangles that are faces; each is written by one chunk
  Components components_;
};

// --- Edges
// ---------------------------------------------------------------------------------------------------

struct EdgeRecord {
  std::uint32_t a, b, index;
  friend auto operator<=>(const EdgeRecord&, const EdgeRecord&) = default;
};

/// The listed edges, with a mark on each that is an edge of some tet or triangle.
class EdgeCheck {
 public:
  explicit EdgeCheck(const MeshData& mesh) : found_(mesh.edges.size(), 0), is_end_(mesh.points.size(), 0) {
    for (std::uint32_t e = 0; e < mesh.edges.size(); ++e) {
      const auto [a, b] = std::minmax(mesh.edges[e][0], mesh.edges[e][1]);
      records_.push_back({a, b, e});
      is_end_[a] = is_end_[b] = 1;
    }
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
  void report(Problems& problems) const {
    for (std::size_t e = 0; e < found_.size(); ++e)
      if (!found_[e]) problems.add("edge ", e + 1, ": is not an edge of any tet or triangle");
  }

 private:
  void mark_edge(std::uint32_t a, std::uint32_t b) {
    if (!is_end_[a] || !is_end_[b]) return;
    if (a > b) std::swap(a, b);
    auto it = std::lower_bound(records_.begin(), records_.end(), EdgeRecord{a, b, 0});
    for (; it != records_.end() && it->a == a && it->b == b; ++it)
      std::atomic_ref(found_[it->index]).store(1, std::memory_order_relaxed);
  }

  std::vector<EdgeRecord> records_;
  std::vector<std::uint8_t> found_;
  std::vector<std::uint8_t> is_end_;
};

// --- Sums
// ----------------------------------------------------------------------------------------------------

using SumsByRef = std::map<std::int32_t, CompensatedSum>;

template <class Size>
std::map<std::int32_t, double> sum_by_ref(const std::vector<std::int32_t>& refs, const Size& size) {
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
    for (const auto& [ref, sum] : part) {
      sums[ref].add(sum.sum);
      sums[ref].add(sum.lost);
    }
  std::map<std::int32_t, double> values;
  for (const auto& [ref, sum] : sums) values[ref] = sum.value();
  return values;
}

void sum_sizes(const MeshData& mesh, CheckReport& report) {
  const auto& p = mesh.points;
  report.volume_by_ref = sum_by_ref(mesh.tet_refs, [&](std::size_t t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    return six_volume(p[a], p[b], p[c], p[d]) / 6;
  });
  report.area_by_ref = sum_by_ref(mesh.triangle_refs, [&](std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return norm(cross(p[b] - p[a], p[c] - p[a])) / 2;
  });
  CompensatedSum volume;
  for (const auto& [ref, part] : report.volume_by_ref) volume.add(part);
  report.volume = volume.value();
}

std::uint64_t count_unreferenced(const MeshData& mesh) {
  std::vector<std::uint8_t> used(mesh.points.size(), 0);
  for (const Tet& tet : mesh.tets)
    for (const std::uint32_t v : tet) used[v] = 1;
  return static_cast<std::uint64_t>(std::count(used.begin(), used.end(), 0));
}

}  // namespace

void check_arrays(const MeshData& mesh, Problems& problems) {
  check_references("vertex", mesh.point_refs.size(), mesh.points.size(), problems);
  check_references("tet", mesh.tet_refs.size(), mesh.tets.size(), problems);
  check_references("triangle", mesh.triangle_refs.size(), mesh.triangles.size(), problems);
  check_references("edge", mesh.edge_refs.size(), mesh.edges.size(), problems);
  check_coordinates(mesh.points, problems);
  check_vertices("tet", mesh.tets, mesh.points.size(), problems);
  check_vertices("triangle", mesh.triangles, mesh.points.size(), problems);
  check_vertices("edge", mesh.edges, mesh.points.size(), problems);
  check_list("corner", mesh.corners, mesh.points.size(), problems);
  check_list("required vertex", mesh.required_points, mesh.points.size(), problems);
  check_list("ridge", mesh.ridges, mesh.edges.size(), problems);
  check_list("required edge", mesh.required_edges, mesh.edges.size(), problems);
  check_list("required triangle", mesh.required_triangles, mesh.triangles.size(), problems);
  if (mesh.tets.size() >= std::size_t{1} << 30) problems.add("more than 1073741823 tets");
}

CheckReport check_mesh(const MeshData& mesh, int max_problems) {
  CheckReport report;
  Problems problems(static_cast<std::size_t>(std::max(max_problems, 0)));
  check_arrays(mesh, problems);
  if (problems.count() == 0) {
    const std::vector<std::int8_t> signs = orientations(mesh, problems);
    FaceCheck faces(mesh, signs);
    faces.run(problems);
    report.num_components = faces.num_components();
    EdgeCheck edges(mesh);
    edges.mark(mesh.tets);
    edges.mark(mesh.triangles);
    edges.report(problems);
    sum_sizes(mesh, report);
    report.unreferenced_points = count_unreferenced(mesh);
    report.touching_edges = faces.count_touching_edges();
    report.touching_vertices = faces.count_balls() - (mesh.points.size() - report.unreferenced_points);
  }
  report.num_problems = problems.count();
  report.problems = problems.take();
  return report;
}

}  // namespace weft::meshing
