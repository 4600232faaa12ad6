// Merging of points, mending of degenerate triangles, search for free edges and self-intersections.
#include "meshing/initial/closed_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/initial/clean_triangles.h"
#include "meshing/initial/self_intersections.h"
#include "meshing/kernel/import_mesh.h"
#include "meshing/mesh/polygon.h"

namespace weft::meshing {
namespace {

constexpr std::uint32_t kDropped = TriangleCleaning::kUnused;

class Cleaning {
 public:
  Cleaning(const MeshData& input, const SurfaceChecks& checks) : input_(input) {
    Box box;
    for (const Triangle& t : input.triangles)
      for (const std::uint32_t v : t) box.include(input.points[v]);
    tolerance_ = checks.merge_tolerance * norm(box.size());
    loose_.corners = input.triangles;
    loose_.refs = input.triangle_refs;
    loose_.sheets.assign(loose_.size(), 1);
    loose_.source.resize(loose_.size());
    std::iota(loose_.source.begin(), loose_.source.end(), 0u);
  }

  ClosedSurface run() {
    TriangleCleaning cleaning(input_.points, loose_, tolerance_);
    warn(cleaning.merge_points(), "points merged with others at the same place");
    warn(cleaning.drop_collapsed(), "triangles without area dropped");
    warn(cleaning.mend_degenerate(), "degenerate triangles given to their neighbours");
    warn(cleaning.merge_repeated(), "repeated triangles merged (common faces of touching solids)");
    merged_ = cleaning.merged();
    if (triangles_.empty()) throw InputError("", "Triangles", "the surface has none");
    check_free_edges();
    check_intersections();
    fill_result();
    return std::move(result_);
  }

 private:
  void warn(std::size_t count, const char* what) {
    if (count > 0) result_.warnings.push_back(fmt::format("{} {}", count, what));
  }

  void check_free_edges() const {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;
    edges.reserve(3 * triangles_.size());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        edges.emplace_back(edge_key(triangles_[i][k], triangles_[i][(k + 1) % 3]), i);
    std::sort(edges.begin(), edges.end());
    std::size_t free = 0, first = 0;
    for (std::size_t i = 0; i < edges.size();) {
      std::size_t j = i;
      while (j < edges.size() && edges[j].first == edges[i].first) ++j;
      if (j == i + 1 && free++ == 0) first = i;
      i = j;
    }
    if (free > 0) throw_open(edges[first].first, edges[first].second, free);
  }

  [[noreturn]] void throw_open(std::uint64_t edge, std::uint32_t triangle, std::size_t count) const {
    const auto a = static_cast<std::uint32_t>(edge >> 32), b = static_cast<std::uint32_t>(edge);
    const Point p = midpoint(input_.points[a], input_.points[b]);
    throw InputError(
        "", fmt::format("triangle {}", source_[triangle] + 1),
        fmt::format("the surface is open: no other triangle has its edge ({}, {}) near ({:.6g}, {:.6g}, "
                    "{:.6g}); {} such edge{} in all",
                    a + 1, b + 1, p.x, p.y, p.z, count, count == 1 ? "" : "s"));
  }

  void check_intersections() const {
    constexpr std::size_t kMostNamed = 5;
    const auto pairs = self_intersections(input_.points, triangles_, kMostNamed + 1);
    if (pairs.empty()) return;
    std::string text = "the surface intersects itself: triangles ";
    for (std::size_t i = 0; i < std::min(pairs.size(), kMostNamed); ++i)
      text +=
          fmt::format("{}{} and {}", i > 0 ? ", " : "", source_[pairs[i][0]] + 1, source_[pairs[i][1]] + 1);
    if (pairs.size() > kMostNamed) text += " and more";
    throw InputError("", fmt::format("triangle {}", source_[pairs[0][0]] + 1), text);
  }

  void fill_result() {
    MeshData& m = result_.mesh;
    std::vector<std::uint32_t> new_index(input_.points.size(), kDropped);
    for (Triangle& t : triangles_)
      for (std::uint32_t& v : t) {
        if (new_index[v] == kDropped) {
          new_index[v] = static_cast<std::uint32_t>(m.points.size());
          m.points.push_back(input_.points[v]);
          m.point_refs.push_back(input_.point_refs[v]);
        }
        v = new_index[v];
      }
    m.triangles = std::move(triangles_);
    m.triangle_refs = std::move(loose_.refs);
    result_.source = std::move(source_);
    const auto renumbered = [&](std::uint32_t v) {
      return merged_[v] == kDropped ? kDropped : new_index[merged_[v]];
    };
    copy_edges(renumbered);
    for (const std::uint32_t v : input_.corners)
      if (renumbered(v) != kDropped) m.corners.push_back(renumbered(v));
  }

  /// Listed edges that still are edges of triangles, and which of them are ridges.
  template <class Renumbered>
  void copy_edges(const Renumbered& renumbered) {
    MeshData& m = result_.mesh;
    std::unordered_map<std::uint64_t, bool> there;
    for (const Triangle& t : m.triangles)
      for (std::size_t k = 0; k < 3; ++k) there[edge_key(t[k], t[(k + 1) % 3])] = true;
    std::vector<bool> ridge(input_.edges.size());
    for (const std::uint32_t r : input_.ridges) ridge[r] = true;
    for (std::size_t i = 0; i < input_.edges.size(); ++i) {
      const std::uint32_t a = renumbered(input_.edges[i][0]), b = renumbered(input_.edges[i][1]);
      if (a == kDropped || b == kDropped || !there.contains(edge_key(a, b))) continue;
      if (ridge[i]) m.ridges.push_back(static_cast<std::uint32_t>(m.edges.size()));
      m.edges.push_back({a, b});
      m.edge_refs.push_back(input_.edge_refs[i]);
    }
  }

  const MeshData& input_;
  double tolerance_ = 0;
  LooseTriangles loose_;
  std::vector<Triangle>& triangles_ = loose_.corners;
  std::vector<std::uint32_t>& source_ = loose_.source;
  std::vector<std::uint32_t> merged_;
  ClosedSurface result_;
};

}  // namespace

ClosedSurface close_surface(const MeshData& input, const SurfaceChecks& checks) {
  check_arrays(input);
  if (input.triangles.empty()) throw InputError("", "Triangles", "the surface has none");
  return Cleaning(input, checks).run();
}

}  // namespace weft::meshing
