// Seams, T-junctions and holes.
#include "meshing/initial/repair_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>

#include "meshing/base/box.h"
#include "meshing/initial/clean_triangles.h"
#include "meshing/initial/grid/interrupted.h"
#include "meshing/initial/mending/listed_edges.h"
#include "meshing/initial/mending/resolve_surface.h"
#include "meshing/mesh/polygon.h"
#include "meshing/mesh/repair/point_tree.h"

namespace weft::meshing {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// Of the diagonal: points nearer than this are one whatever they belong to; a seam may be this wide, and a
// hole this large.
constexpr double kSamePlace = 1e-9, kWidestSeam = 2e-3, kLargestHole = 0.1;
// Of the shortest free edge at a vertex: farther it does not move.
constexpr double kShareOfEdge = 0.3;
constexpr std::size_t kMostSides = 100;
constexpr double kMargin = 2;  // boxes are searched that are larger than they must be, for their rounding

Edge undirected(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

Triangle ascending(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

class SurfaceRepair {
 public:
  SurfaceRepair(MeshData& surface, const std::atomic<bool>* interrupt)
      : m_(surface), interrupt_(interrupt), edges_(surface) {
    if (m_.triangle_refs.empty()) m_.triangle_refs.assign(m_.triangles.size(), 0);
    if (m_.edge_refs.empty()) m_.edge_refs.assign(m_.edges.size(), 0);
    Box box;
    for (const Triangle& t : m_.triangles)
      for (const std::uint32_t v : t)
        if (v < m_.points.size()) box.include(m_.points[v]);
    diagonal_ = norm(box.size());
    source_.resize(m_.triangles.size());
    std::iota(source_.begin(), source_.end(), 0u);
    required_.resize(m_.triangles.size());
    for (const std::uint32_t t : m_.required_triangles)
      if (t < required_.size()) required_[t] = true;
  }

  std::vector<MeshMend> run(std::string* left) {
    if (!std::isfinite(diagonal_)) return {};  // too large: close_surface() refuses it
    merge_same();
    constexpr int kMostRounds = 4;
    for (int round = 0; round < kMostRounds && !free_edges().empty(); ++round) {
      check_interrupt(interrupt_);
      if (merge_across_seams() + split_at_junctions() == 0) break;
    }
    fill_holes();
    edges_.give_to(m_);
    std::string why = resolve_surface(m_, source_, mends_, interrupt_);
    list_required();
    if (left) *left = std::move(why);
    return std::move(mends_);
  }

  const std::vector<std::uint32_t>& source() const { return source_; }

 private:
  MeshMend& mend(const char* what, const char* entity, const char* unit = "") {
    for (MeshMend& known : mends_)
      if (known.what == what) return known;
    mends_.push_back({what, entity, 0, {}, 0, unit});
    return mends_.back();
  }

  /// Edges that one triangle has, or three: from its triangle's side, with the triangle.
  std::map<Edge, std::uint32_t> free_edges() const {
    std::map<Edge, std::vector<std::uint32_t>> triangles;
    for (std::uint32_t i = 0; i < m_.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        triangles[undirected(m_.triangles[i][k], m_.triangles[i][(k + 1) % 3])].push_back(i);
    std::map<Edge, std::uint32_t> free;
    for (const auto& [edge, at] : triangles)
      if (at.size() == 1) free.emplace(edge, at[0]);
    return free;
  }

  /// How far each vertex of a free edge may be from what it is joined to.
  std::map<std::uint32_t, double> reaches(const std::map<Edge, std::uint32_t>& free) const {
    std::map<std::uint32_t, double> reach;
    for (const auto& [edge, triangle] : free) {
      const double length = norm(m_.points[edge.first] - m_.points[edge.second]);
      for (const std::uint32_t v : {edge.first, edge.second}) {
        const auto [at, is_new] = reach.try_emplace(v, kWidestSeam * diagonal_);
        at->second = std::min(at->second, kShareOfEdge * length);
      }
    }
    return reach;
  }

  /// Renumbers, and drops what has collapsed or is there twice: what stays is required if one of them was.
  void renumber(const std::vector<std::uint32_t>& now) {
    std::map<Triangle, std::uint32_t> there;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < m_.triangles.size(); ++i) {
      Triangle t = m_.triangles[i];
      for (std::uint32_t& v : t)
        if (v < now.size()) v = now[v];
      const Triangle key = ascending(t);
      const bool collapsed = key[0] == key[1] || key[1] == key[2];
      const auto [first, is_new] = there.try_emplace(key, source_[i]);
      if (collapsed || !is_new) {
        if (!collapsed && required_[source_[i]]) required_[first->second] = true;
        mend(collapsed ? "triangles without area removed" : "repeated triangles removed", "triangle")
            .add(source_[i]);
        continue;
      }
      m_.triangles[kept] = t;
      m_.triangle_refs[kept] = m_.triangle_refs[i];
      source_[kept++] = source_[i];
    }
    m_.triangles.resize(kept), m_.triangle_refs.resize(kept), source_.resize(kept);
    edges_.renumber(now);
    for (auto* list : {&m_.corners, &m_.required_points})
      for (std::uint32_t& v : *list)
        if (v < now.size()) v = now[v];
  }

  /// Pieces of required triangles, by their new numbers; and what closes an opening beside one, as it has
  /// that one's reference.
  void list_required() {
    m_.required_triangles.clear();
    for (std::uint32_t t = 0; t < source_.size(); ++t)
      if (required_[source_[t]]) m_.required_triangles.push_back(t);
  }

  std::vector<std::uint32_t> by_x(std::vector<std::uint32_t> vertices) const {
    std::sort(vertices.begin(), vertices.end(), [&](std::uint32_t a, std::uint32_t b) {
      return m_.points[a].x != m_.points[b].x ? m_.points[a].x < m_.points[b].x : a < b;
    });
    return vertices;
  }

  void merge_same() {
    std::vector<std::uint32_t> now(m_.points.size()), all(m_.points.size());
    std::iota(now.begin(), now.end(), 0u);
    std::iota(all.begin(), all.end(), 0u);
    const std::vector<std::uint32_t> order = by_x(all);
    const double tolerance = kSamePlace * diagonal_;
    const PointTree tree(m_.points, order);
    for (const std::uint32_t a : order) {
      Box box;
      box.include(m_.points[a]);
      std::vector<std::uint32_t> near;
      tree.visit_in(box.grown(tolerance), [&](std::uint32_t b) {
        if (std::pair(m_.points[a].x, a) < std::pair(m_.points[b].x, b)) near.push_back(b);
      });
      for (const std::uint32_t b : by_x(std::move(near))) {
        const double distance = norm(m_.points[a] - m_.points[b]);
        if (distance > tolerance || now[b] != b || now[a] == b) continue;
        now[b] = now[a];
        mend("vertices at the same place merged", "vertex", "distance").add(b, distance);
      }
    }
    renumber(now);
  }

  PointTree tree_of(const std::map<std::uint32_t, double>& reach) const {
    std::vector<std::uint32_t> vertices;
    for (const auto& [v, r] : reach) vertices.push_back(v);
    return {m_.points, std::move(vertices)};
  }

  /// The nearest pairs first, each vertex once a round; not the two ends of an edge.
  std::size_t merge_across_seams() {
    const auto free = free_edges();
    const auto reach = reaches(free);
    const PointTree tree = tree_of(reach);
    std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;
    for (const auto& at : reach) {
      check_interrupt(interrupt_);
      const std::uint32_t a = at.first;
      const double r = at.second;
      Box box;
      box.include(m_.points[a]);
      tree.visit_in(box.grown(kMargin * r), [&](std::uint32_t b) {
        if (b <= a) return;
        const double distance = norm(m_.points[a] - m_.points[b]);
        if (distance <= std::min(r, reach.at(b)) && !free.contains({a, b}))
          pairs.emplace_back(distance, a, b);
      });
    }
    std::sort(pairs.begin(), pairs.end());
    std::vector<std::uint32_t> now(m_.points.size());
    std::iota(now.begin(), now.end(), 0u);
    std::set<std::uint32_t> moved;
    std::size_t count = 0;
    for (const auto& [distance, a, b] : pairs) {
      if (moved.contains(a) || moved.contains(b)) continue;
      moved.insert(a), moved.insert(b);
      now[b] = a;
      mend("vertices joined across seams", "vertex", "distance").add(b, distance);
      ++count;
    }
    if (count > 0) renumber(now);
    return count;
  }

  /// The distance of p from the edge's inner part, if it is opposite that.
  std::optional<double> distance_from(const Edge& edge, const Point& p) const {
    const Point a = m_.points[edge.first], along = m_.points[edge.second] - a;
    const double square = norm2(along);
    const double at = square > 0 ? dot(p - a, along) / square : 0;
    if (!(at > 0) || !(at < 1)) return {};
    return norm(p - (a + at * along));
  }

  /// Free edges with a free vertex beside them; each triangle is split once a round.
  std::size_t split_at_junctions() {
    const auto free = free_edges();
    const auto reach = reaches(free);
    const PointTree tree = tree_of(reach);
    double farthest = 0;
    for (const auto& [v, r] : reach) farthest = std::max(farthest, r);
    std::set<std::uint32_t> split;
    EdgeCuts cuts;
    std::size_t count = 0;
    for (const auto& at : free) {
      check_interrupt(interrupt_);
      const Edge edge = at.first;
      const std::uint32_t triangle = at.second;
      if (split.contains(triangle)) continue;
      double nearest = std::numeric_limits<double>::max();
      std::uint32_t vertex = 0;
      Box box;
      box.include(m_.points[edge.first]);
      box.include(m_.points[edge.second]);
      tree.visit_in(box.grown(kMargin * farthest), [&](std::uint32_t v) {
        if (v == edge.first || v == edge.second) return;
        const auto distance = distance_from(edge, m_.points[v]);
        if (distance && *distance <= reach.at(v) && std::pair(*distance, v) < std::pair(nearest, vertex))
          nearest = *distance, vertex = v;
      });
      if (nearest == std::numeric_limits<double>::max() || !split_triangle(triangle, edge, vertex)) continue;
      split.insert(triangle);
      cuts[edge_key(edge.first, edge.second)] = {vertex};
      mend("triangles split at vertices beside their free edges", "triangle", "distance")
          .add(source_[triangle], nearest);
      ++count;
    }
    edges_.cut(cuts);
    return count;
  }

  bool split_triangle(std::uint32_t triangle, const Edge& edge, std::uint32_t vertex) {
    const Triangle t = m_.triangles[triangle];
    if (std::find(t.begin(), t.end(), vertex) != t.end()) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (undirected(t[k], t[(k + 1) % 3]) != edge) continue;
      m_.triangles[triangle] = {t[k], vertex, t[(k + 2) % 3]};
      m_.triangles.push_back({vertex, t[(k + 1) % 3], t[(k + 2) % 3]});
      m_.triangle_refs.push_back(m_.triangle_refs[triangle]);
      source_.push_back(source_[triangle]);
      return true;
    }
    return false;
  }

  // --- Holes

  void fill_holes() {
    const auto free = free_edges();
    std::set<Triangle> there;
    if (!free.empty())
      for (const Triangle& t : m_.triangles) there.insert(ascending(t));
    std::map<std::uint32_t, std::vector<std::uint32_t>> next;
    for (const auto& [edge, triangle] : free) {
      next[edge.first].push_back(edge.second);
      next[edge.second].push_back(edge.first);
    }
    std::set<std::uint32_t> visited;
    for (const auto& [first, ends] : next) {
      if (visited.contains(first)) continue;
      const std::vector<std::uint32_t> loop = loop_from(first, next, visited);
      if (loop.size() >= 3 && is_small(loop)) fill(loop, free, there);
    }
  }

  /// Empty where more than two free edges meet at a vertex, or the path ends.
  static std::vector<std::uint32_t> loop_from(std::uint32_t first,
                                              const std::map<std::uint32_t, std::vector<std::uint32_t>>& next,
                                              std::set<std::uint32_t>& visited) {
    std::vector<std::uint32_t> loop;
    bool simple = true;
    for (std::uint32_t at = first;;) {
      visited.insert(at);
      loop.push_back(at);
      simple &= next.at(at).size() == 2;
      std::optional<std::uint32_t> to;
      for (const std::uint32_t v : next.at(at))
        if (!visited.contains(v)) to = v;
      if (!to) break;
      at = *to;
    }
    const auto& last = next.at(loop.back());
    const bool closed = std::find(last.begin(), last.end(), first) != last.end();
    return simple && closed ? loop : std::vector<std::uint32_t>{};
  }

  double size_of(const std::vector<std::uint32_t>& loop) const {
    Box box;
    for (const std::uint32_t v : loop) box.include(m_.points[v]);
    return norm(box.size());
  }

  bool is_small(const std::vector<std::uint32_t>& loop) const {
    return loop.size() <= kMostSides && size_of(loop) <= kLargestHole * diagonal_;
  }

  /// Not where that would repeat a triangle: the loop is no hole then, but the border of a loose triangle.
  void fill(const std::vector<std::uint32_t>& loop, const std::map<Edge, std::uint32_t>& free,
            const std::set<Triangle>& there) {
    const std::uint32_t beside = free.at(undirected(loop.front(), loop.back()));
    const std::vector<Triangle> lid = triangulate_loop(m_.points, loop);
    if (std::ranges::any_of(lid, [&](const Triangle& t) { return there.contains(ascending(t)); })) return;
    for (const Triangle& t : lid) {
      m_.triangles.push_back(t);
      m_.triangle_refs.push_back(m_.triangle_refs[beside]);
      source_.push_back(source_[beside]);
    }
    mend("holes filled", "triangle beside", "size").add(source_[beside], size_of(loop));
  }

  MeshData& m_;
  const std::atomic<bool>* interrupt_;
  double diagonal_ = 0;
  std::vector<std::uint32_t> source_;  ///< of each triangle: its number in the input
  std::vector<bool> required_;         ///< of each triangle of the input
  ListedEdges edges_;
  std::vector<MeshMend> mends_;
};

}  // namespace

std::vector<MeshMend> repair_surface(MeshData& surface, std::string* left, const std::atomic<bool>* interrupt,
                                     std::vector<std::uint32_t>* source) {
  SurfaceRepair repair(surface, interrupt);
  std::vector<MeshMend> mends = repair.run(left);
  if (source) *source = repair.source();
  return mends;
}

}  // namespace weft::meshing
