// A descent, vertex by vertex, on the number of tets that are not positive and the least volume.
#include "meshing/mesh/repair/untangle.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/repair/signed_tets.h"

namespace weft::meshing {
namespace {

class Untangling {
 public:
  Untangling(MeshData& mesh, VertexGroup group)
      : m_(mesh),
        bad_(tets_not_positive(mesh)),
        tets_(vertex_tets(mesh.tets, mesh.points.size())),
        near_(vertex_neighbours(mesh.tets, mesh.points.size())),
        where_(mesh.points.size(), Where::inside) {
    find_boundary(group);
    if (group == VertexGroup::ridge) find_ridges();
  }

  std::vector<MovedPoint> run() {
    constexpr int kMostRounds = 50;
    for (int round = 0; round < kMostRounds && !bad_.empty(); ++round) {
      bool any = false;
      for (const Where where : {Where::on_ridge, Where::on_boundary, Where::inside})
        for (const std::uint32_t t : bad_)
          for (const std::uint32_t v : m_.tets[t])
            if (where_[v] == where && may_move(v)) any |= improve_place(v);
      bad_ = tets_not_positive(m_);
      if (!any) break;
    }
    std::vector<MovedPoint> moved;
    for (const auto& [v, point] : before_)
      if (!(point == m_.points[v])) moved.push_back({v, point});
    return moved;
  }

 private:
  enum class Where : std::uint8_t { inside, on_boundary, on_ridge, held };

  /// A tet that was good may have become bad for another's sake: of its boundary vertices nothing is known.
  bool may_move(std::uint32_t v) const { return where_[v] != Where::on_boundary || faces_.contains(v); }

  /// Corners, and the vertices of what is required.
  std::vector<std::uint32_t> fixed() const {
    std::vector<std::uint32_t> all = m_.corners;
    all.insert(all.end(), m_.required_points.begin(), m_.required_points.end());
    for (const std::uint32_t e : m_.required_edges)
      if (e < m_.edges.size()) all.insert(all.end(), m_.edges[e].begin(), m_.edges[e].end());
    for (const std::uint32_t t : m_.required_triangles)
      if (t < m_.triangles.size()) all.insert(all.end(), m_.triangles[t].begin(), m_.triangles[t].end());
    return all;
  }

  /// Boundary vertices of bad tets, with their faces there; all others there are held, and what is listed.
  void find_boundary(VertexGroup group) {
    const Where on_boundary = group == VertexGroup::inner ? Where::held : Where::on_boundary;
    const Adjacency adjacency = build_adjacency(m_.tets, m_.points.size());
    for (std::size_t t = 0; t < m_.tets.size(); ++t)
      for (int f = 0; f < 4; ++f)
        if (adjacency.neighbours[t][f] == kNoNeighbour)
          for (const std::uint32_t v : face_of(m_.tets[t], f)) where_[v] = on_boundary;
    const auto hold = [&](std::uint32_t v) {
      if (v < where_.size()) where_[v] = Where::held;
    };
    for (const auto& t : m_.triangles)
      for (const std::uint32_t v : t)
        if (v < where_.size() && where_[v] == Where::inside) hold(v);  // between materials
    for (const auto& e : m_.edges) std::for_each(e.begin(), e.end(), hold);
    for (const std::uint32_t v : fixed()) hold(v);
    for (const std::uint32_t t : bad_)
      for (const std::uint32_t v : m_.tets[t])
        if (where_[v] == Where::on_boundary) faces_[v];
    for (std::size_t t = 0; t < m_.tets.size() && !faces_.empty(); ++t)
      for (int f = 0; f < 4; ++f)
        if (adjacency.neighbours[t][f] == kNoNeighbour) {
          const Triangle face = face_of(m_.tets[t], f);
          for (const std::uint32_t v : face)
            if (const auto at = faces_.find(v); at != faces_.end()) at->second.push_back(face);
        }
  }

  /// Of the vertices of bad tets. One along whose ridge nobody knows the way, with three neighbours there,
  /// say, is held.
  void find_ridges() {
    using Edge = std::array<std::uint32_t, 2>;
    std::map<std::uint32_t, std::set<std::uint32_t>> along;
    const auto add = [&](const Edge& e) {
      for (const auto& [v, n] : {std::pair{e[0], e[1]}, {e[1], e[0]}})
        if (const auto at = along.find(v); at != along.end()) at->second.insert(n);
    };
    for (const std::uint32_t t : bad_)
      for (const std::uint32_t v : m_.tets[t]) along[v];
    for (const Edge& e : m_.edges)
      if (std::max(e[0], e[1]) < m_.points.size()) add(e);
    std::map<Edge, std::set<std::int32_t>> refs;
    for (std::size_t i = 0; i < m_.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = m_.triangles[i][k], b = m_.triangles[i][(k + 1) % 3];
        if (std::max(a, b) < m_.points.size() && (along.contains(a) || along.contains(b)))
          refs[{std::min(a, b), std::max(a, b)}].insert(m_.triangle_refs[i]);
      }
    for (const auto& [edge, there] : refs)
      if (there.size() > 1) add(edge);
    for (const std::uint32_t v : fixed()) along.erase(v);
    for (const auto& [v, ends] : along) {
      if (ends.empty()) continue;
      where_[v] = ends.size() == 2 ? Where::on_ridge : Where::held;
      if (ends.size() == 2) ridges_[v] = {*ends.begin(), *ends.rbegin()};
    }
  }

  /// Of the tets at a vertex, how many are not positive, and the smallest volume.
  std::pair<int, double> state_of(std::uint32_t v) const {
    int bad = 0;
    double least = std::numeric_limits<double>::max();
    for (const std::uint32_t t : tets_.of(v)) {
      bad += sign_of(m_, m_.tets[t]) <= 0;
      least = std::min(least, volume(m_, m_.tets[t]));
    }
    return {bad, least};
  }

  /// The middle of the neighbours; of a boundary vertex, of those there; on a ridge, of the two along it.
  Point middle_of(std::uint32_t v) const {
    if (where_[v] == Where::on_ridge) {
      const auto& [a, b] = ridges_.at(v);
      return 0.5 * (m_.points[a] + m_.points[b]);
    }
    Point sum{};
    double count = 0;
    const auto add = [&](std::uint32_t n) {
      sum = sum + m_.points[n];
      ++count;
    };
    if (where_[v] == Where::inside) {
      for (const std::uint32_t n : near_.of(v)) add(n);
    } else {
      for (const Triangle& face : faces_.at(v))
        for (const std::uint32_t n : face)
          if (n != v) add(n);
    }
    return (1 / count) * sum;
  }

  /// Whether the boundary's triangles at a vertex there face the same way, within 30 degrees of their mean.
  bool is_smooth(std::uint32_t v) const {
    constexpr double kLeastCosine = 0.866;
    const auto normal = [&](const Triangle& f) {
      return cross(m_.points[f[1]] - m_.points[f[0]], m_.points[f[2]] - m_.points[f[0]]);
    };
    Vec sum{};
    for (const Triangle& f : faces_.at(v)) sum = sum + normal(f);
    return std::ranges::all_of(faces_.at(v), [&](const Triangle& f) {
      const Vec n = normal(f);
      return dot(n, sum) > kLeastCosine * norm(n) * norm(sum);
    });
  }

  bool improve_place(std::uint32_t v) {
    const Point old = m_.points[v], middle = middle_of(v);
    before_.try_emplace(v, old);
    auto best = state_of(v);
    Point best_place = old;
    for (const double share : {1.0, 0.7, 0.4, 0.2, 0.1, 0.03, 0.01}) {
      m_.points[v] = old + share * (middle - old);
      if (where_[v] == Where::on_boundary && !is_smooth(v)) continue;
      const auto state = state_of(v);
      if (state.first > best.first || (state.first == best.first && !(state.second > best.second))) continue;
      best = state;
      best_place = m_.points[v];
    }
    m_.points[v] = best_place;
    return !(best_place == old);
  }

  MeshData& m_;
  std::vector<std::uint32_t> bad_;
  const VertexLists tets_, near_;
  std::vector<Where> where_;
  std::map<std::uint32_t, std::vector<Triangle>>
      faces_;  ///< of the boundary, at vertices that may move there
  std::map<std::uint32_t, std::array<std::uint32_t, 2>> ridges_;  ///< neighbours along them
  std::map<std::uint32_t, Point> before_;
};

}  // namespace

std::vector<MovedPoint> untangle(MeshData& mesh, VertexGroup group) {
  if (tets_not_positive(mesh).empty()) return {};
  return Untangling(mesh, group).run();
}

}  // namespace weft::meshing
