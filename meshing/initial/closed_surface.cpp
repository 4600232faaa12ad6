// Merging of points, mending of degenerate triangles, search for free edges and self-intersections.
#include "meshing/initial/closed_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/initial/self_intersections.h"
#include "meshing/kernel/import_mesh.h"
#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
constexpr std::uint32_t kDropped = 0xFFFFFFFFu;

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

bool collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Numbers of points after those nearer than `tolerance` to an earlier one have become that one.
class NearbyPoints {
 public:
  NearbyPoints(const std::vector<Point>& points, double tolerance)
      : points_(points), tolerance_(tolerance), cell_(std::max(2 * tolerance, 1e-300)) {}

  /// The earlier point that point i coincides with, or i.
  std::uint32_t find_or_add(std::uint32_t i) {
    const Point& p = points_[i];
    for (int k = 0; k < 8; ++k) {
      const Point q = {p.x + (k & 1 ? 1 : -1) * tolerance_, p.y + (k & 2 ? 1 : -1) * tolerance_,
                       p.z + (k & 4 ? 1 : -1) * tolerance_};
      const auto [begin, end] = cells_.equal_range(hash(q));
      for (auto at = begin; at != end; ++at)
        if (norm2(points_[at->second] - p) <= tolerance_ * tolerance_) return at->second;
    }
    cells_.emplace(hash(p), i);
    return i;
  }

 private:
  std::uint64_t hash(const Point& p) const {
    std::uint64_t h = 0;
    for (int i = 0; i < 3; ++i)
      h = (h ^ std::hash<double>{}(std::floor(p[i] / cell_) + 0.0)) * 0x9E3779B97F4A7C15u;
    return h;
  }

  const std::vector<Point>& points_;
  double tolerance_, cell_;
  std::unordered_multimap<std::uint64_t, std::uint32_t> cells_;
};

class Cleaning {
 public:
  Cleaning(const MeshData& input, const SurfaceChecks& checks) : input_(input) {
    Box box;
    for (const Triangle& t : input.triangles)
      for (const std::uint32_t v : t) box.include(input.points[v]);
    tolerance_ = checks.merge_tolerance * norm(box.size());
    triangles_ = input.triangles;
    refs_ = input.triangle_refs;
    source_.resize(triangles_.size());
    std::iota(source_.begin(), source_.end(), 0u);
  }

  ClosedSurface run() {
    merge_points();
    drop_collapsed("triangles without area dropped");
    mend_degenerate();
    merge_repeated();
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

  void merge_points() {
    std::vector<bool> used(input_.points.size());
    for (const Triangle& t : triangles_)
      for (const std::uint32_t v : t) used[v] = true;
    NearbyPoints nearby(input_.points, tolerance_);
    merged_.assign(input_.points.size(), kDropped);
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < merged_.size(); ++i) {
      if (!used[i]) continue;
      merged_[i] = nearby.find_or_add(i);
      count += merged_[i] != i;
    }
    for (Triangle& t : triangles_)
      for (std::uint32_t& v : t) v = merged_[v];
    warn(count, "points merged with others at the same place");
  }

  void drop_collapsed(const char* what) {
    std::vector<bool> drop(triangles_.size());
    for (std::size_t i = 0; i < triangles_.size(); ++i) drop[i] = collapsed(triangles_[i]);
    warn(erase(drop), what);
  }

  std::size_t erase(const std::vector<bool>& drop) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (drop[i]) continue;
      triangles_[kept] = triangles_[i];
      refs_[kept] = refs_[i];
      source_[kept++] = source_[i];
    }
    const std::size_t count = triangles_.size() - kept;
    triangles_.resize(kept), refs_.resize(kept), source_.resize(kept);
    return count;
  }

  /// The corner opposite the longest edge when it lies on that edge, up to the tolerance; else -1.
  int corner_on_edge(const Triangle& t) const {
    const auto& p = input_.points;
    int apex = 0;
    double longest = 0;
    for (int i = 0; i < 3; ++i) {
      const double length = norm(p[t[(i + 1) % 3]] - p[t[(i + 2) % 3]]);
      if (length <= longest) continue;
      longest = length;
      apex = i;
    }
    const double area = norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
    const bool flat = area <= tolerance_ * longest || collinear(p[t[0]], p[t[1]], p[t[2]]);
    return flat ? apex : -1;
  }

  bool is_between(const Triangle& t, int apex) const {
    const auto& p = input_.points;
    const Point &a = p[t[(apex + 1) % 3]], &b = p[t[(apex + 2) % 3]], &c = p[t[apex]];
    return std::max(norm(c - a), norm(c - b)) < norm(b - a);
  }

  /// A triangle (a, b, c) with c on edge ab gives way: its neighbours beyond ab are split at c. What is
  /// beyond may itself give way (a fan from a cone's tip along a straight line): then who is beyond that is
  /// split at the vertices of both.
  void mend_degenerate() {
    constexpr int kMostRounds = 20;
    std::size_t count = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      const std::size_t mended = mend_round();
      if (mended == 0) break;
      count += mended;
    }
    warn(count, "degenerate triangles given to their neighbours");
  }

  std::size_t mend_round() {
    std::unordered_map<std::uint64_t, std::uint32_t> splits;  // edge -> the vertex on it
    std::vector<bool> drop(triangles_.size());
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const Triangle& t = triangles_[i];
      const int apex = corner_on_edge(t);
      if (apex < 0 || !is_between(t, apex)) continue;
      drop[i] = splits.try_emplace(key(t[(apex + 1) % 3], t[(apex + 2) % 3]), t[apex]).second;
    }
    if (splits.empty()) return 0;
    for (std::size_t i = 0; i < triangles_.size(); ++i)
      while (!drop[i] && split_at(i, splits, drop)) continue;
    erase(drop);
    return splits.size();
  }

  /// Whether it was split: the parts, which have shorter edges, may have one more to be split at.
  bool split_at(std::size_t i, const std::unordered_map<std::uint64_t, std::uint32_t>& splits,
                std::vector<bool>& drop) {
    const Triangle t = triangles_[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const auto at = splits.find(key(a, b));
      if (at == splits.end()) continue;
      if (at->second == c) {
        drop[i] = true;
        return false;
      }
      triangles_[i] = {a, at->second, c};
      triangles_.push_back({at->second, b, c});
      refs_.push_back(refs_[i]);
      source_.push_back(source_[i]);
      drop.push_back(false);
      return true;
    }
    return false;
  }

  void merge_repeated() {
    std::vector<std::uint32_t> order(triangles_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Triangle> keys(triangles_.size());
    std::transform(triangles_.begin(), triangles_.end(), keys.begin(), sorted);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return keys[a] != keys[b] ? keys[a] < keys[b] : a < b;
    });
    std::vector<bool> drop(triangles_.size());
    for (std::size_t i = 1; i < order.size(); ++i) drop[order[i]] = keys[order[i]] == keys[order[i - 1]];
    warn(erase(drop), "repeated triangles merged (common faces of touching solids)");
  }

  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  }

  void check_free_edges() const {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;
    edges.reserve(3 * triangles_.size());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        edges.emplace_back(key(triangles_[i][k], triangles_[i][(k + 1) % 3]), i);
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
    m.triangle_refs = std::move(refs_);
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
      for (std::size_t k = 0; k < 3; ++k) there[key(t[k], t[(k + 1) % 3])] = true;
    std::vector<bool> ridge(input_.edges.size());
    for (const std::uint32_t r : input_.ridges) ridge[r] = true;
    for (std::size_t i = 0; i < input_.edges.size(); ++i) {
      const std::uint32_t a = renumbered(input_.edges[i][0]), b = renumbered(input_.edges[i][1]);
      if (a == kDropped || b == kDropped || !there.contains(key(a, b))) continue;
      if (ridge[i]) m.ridges.push_back(static_cast<std::uint32_t>(m.edges.size()));
      m.edges.push_back({a, b});
      m.edge_refs.push_back(input_.edge_refs[i]);
    }
  }

  const MeshData& input_;
  double tolerance_ = 0;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> refs_;
  std::vector<std::uint32_t> source_, merged_;
  ClosedSurface result_;
};

}  // namespace

ClosedSurface close_surface(const MeshData& input, const SurfaceChecks& checks) {
  check_arrays(input);
  if (input.triangles.empty()) throw InputError("", "Triangles", "the surface has none");
  return Cleaning(input, checks).run();
}

}  // namespace weft::meshing
