// Merging of points, mending of degenerate triangles, search for free edges and self-intersections.
#include "meshing/initial/closed_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

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
    const double diagonal = norm(box.size());
    if (!std::isfinite(diagonal))
      throw InputError("", "Vertices", "the surface is too large: the square of its size is no double");
    tolerance_ = checks.merge_tolerance * diagonal;
    loose_.corners = input.triangles;
    loose_.refs = input.triangle_refs;
    loose_.sheets.assign(loose_.size(), 1);
    loose_.source = checks.source;
    if (checks.source.empty()) {
      loose_.source.resize(loose_.size());
      std::iota(loose_.source.begin(), loose_.source.end(), 0u);
    }
    for (const std::uint32_t t : input.required_triangles) required_.insert(loose_.source[t]);
  }

  ClosedSurface run() {
    TriangleCleaning cleaning(input_.points, loose_, tolerance_);
    warn(cleaning.merge_points(), "points merged with others at the same place");
    warn(cleaning.drop_collapsed(), "triangles without area dropped");
    warn(cleaning.mend_degenerate(), "degenerate triangles given to their neighbours");
    warn(cleaning.merge_repeated(), "repeated triangles merged (common faces of touching solids)");
    merged_ = cleaning.merged();
    splits_ = cleaning.splits();
    for (const auto& [dropped, kept] : cleaning.repeated())
      if (required_.contains(dropped)) required_.insert(kept);
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
    new_index_.assign(input_.points.size(), kDropped);
    for (Triangle& t : triangles_)
      for (std::uint32_t& v : t) {
        if (new_index_[v] == kDropped) {
          new_index_[v] = static_cast<std::uint32_t>(m.points.size());
          m.points.push_back(input_.points[v]);
          m.point_refs.push_back(input_.point_refs[v]);
        }
        v = new_index_[v];
      }
    m.triangles = std::move(triangles_);
    m.triangle_refs = std::move(loose_.refs);
    result_.source = std::move(source_);
    copy_edges();
    copy_points(input_.corners, m.corners);
    copy_points(input_.required_points, m.required_points);
    mark_required();
  }

  void copy_points(const std::vector<std::uint32_t>& list, std::vector<std::uint32_t>& to) const {
    for (const std::uint32_t v : list)
      if (merged_[v] != kDropped && new_index_[merged_[v]] != kDropped) to.push_back(new_index_[merged_[v]]);
  }

  /// Listed edges that still are edges of triangles, or whose pieces are, and what they are marked as.
  void copy_edges() {
    MeshData& m = result_.mesh;
    for (const Triangle& t : m.triangles)
      for (std::size_t k = 0; k < 3; ++k) edges_.insert(edge_key(t[k], t[(k + 1) % 3]));
    std::vector<bool> ridge(input_.edges.size()), required(input_.edges.size());
    for (const std::uint32_t e : input_.ridges) ridge[e] = true;
    for (const std::uint32_t e : input_.required_edges) required[e] = true;
    for (std::size_t i = 0; i < input_.edges.size(); ++i) {
      const std::uint32_t a = merged_[input_.edges[i][0]], b = merged_[input_.edges[i][1]];
      if (a == kDropped || b == kDropped) continue;
      auto e = static_cast<std::uint32_t>(m.edges.size());
      add_pieces(a, b);
      m.edge_refs.resize(m.edges.size(), input_.edge_refs[i]);
      for (; e < m.edges.size(); ++e) {
        if (ridge[i]) m.ridges.push_back(e);
        if (required[i]) m.required_edges.push_back(e);
      }
    }
  }

  /// The edge itself, if triangles have it, else what it was split into. Ends, because pieces are shorter.
  void add_pieces(std::uint32_t a, std::uint32_t b) {
    if (edges_.contains(edge_key(new_index_[a], new_index_[b]))) {
      result_.mesh.edges.push_back({new_index_[a], new_index_[b]});
    } else if (const auto at = splits_.find(edge_key(a, b)); at != splits_.end()) {
      add_pieces(a, at->second);
      add_pieces(at->second, b);
    }
  }

  void mark_required() {
    for (std::uint32_t t = 0; t < result_.source.size(); ++t)
      if (required_.contains(result_.source[t])) result_.mesh.required_triangles.push_back(t);
  }

  const MeshData& input_;
  double tolerance_ = 0;
  LooseTriangles loose_;
  std::vector<Triangle>& triangles_ = loose_.corners;
  std::vector<std::uint32_t>& source_ = loose_.source;
  std::unordered_set<std::uint32_t> required_;  ///< numbers of triangles, as in source_
  std::vector<std::uint32_t> merged_, new_index_;
  std::unordered_map<std::uint64_t, std::uint32_t> splits_;
  std::unordered_set<std::uint64_t> edges_;  ///< of the result's triangles
  ClosedSurface result_;
};

}  // namespace

ClosedSurface close_surface(const MeshData& input, const SurfaceChecks& checks) {
  check_arrays(input);
  if (input.triangles.empty()) throw InputError("", "Triangles", "the surface has none");
  return Cleaning(input, checks).run();
}

}  // namespace weft::meshing
