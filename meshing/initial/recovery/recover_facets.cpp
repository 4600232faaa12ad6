// Facets become grid faces by a front that grows from their edges; a grid edge in its way is swapped away or
// split where the facet cuts it.
#include "meshing/initial/recovery/recover_facets.h"

#include <algorithm>

#include "meshing/initial/recovery/insert_steiner.h"
#include "meshing/initial/recovery/relax_steiner.h"
#include "meshing/initial/recovery/remove_edge.h"

namespace weft::meshing {
namespace {

class FacetRecovery {
 public:
  explicit FacetRecovery(Recovery& r) : r_(r), grid_(r.grid) {}

  void run() {
    for (facet_ = 0; facet_ < r_.facets.size(); ++facet_) recover();
  }

 private:
  /// What lies beyond a front edge: a vertex of the facet, or a grid edge that cuts the facet.
  struct Beyond {
    std::uint32_t vertex = kNothing, below = kNothing, above = kNothing;
    std::uint32_t tet = kNothing;
  };

  void recover() {
    front_.clear();
    apex_ = r_.above(facet_);
    for (std::size_t i = 0; i < 3; ++i) add_border(i);
    while (!front_.empty()) {
      const auto [s, t] = front_.back();
      Beyond b = look_beyond(s, t);
      if (b.vertex == kNothing) {
        if (!swap_away(b)) split(b);
        continue;
      }
      accept(s, t, b);
    }
  }

  const Face3& corners() const { return r_.facets[facet_]; }

  void add_border(std::size_t i) {
    const InputEdge& edge = r_.edges[r_.facet_edges[facet_][i]];
    std::vector<std::uint32_t> path = edge.chain;
    path.insert(path.begin(), edge.a);
    path.push_back(edge.b);
    if (edge.a != corners()[i]) std::reverse(path.begin(), path.end());
    for (std::size_t k = 0; k + 1 < path.size(); ++k) {
      put_on_facet(path[k]);
      front_.emplace_back(path[k], path[k + 1]);
    }
  }

  void put_on_facet(std::uint32_t v) {
    on_facet_.resize(grid_.points.size(), kNothing);
    on_facet_[v] = facet_;
  }
  bool on_facet(std::uint32_t v) const { return v < on_facet_.size() && on_facet_[v] == facet_; }

  /// 0 on the facet (by construction, not by rounded coordinates), 1 above, -1 below. Points of the facet's
  /// plane outside it are counted as above: they never stand inwards of a front edge.
  int level(std::uint32_t v) const {
    if (on_facet(v)) return 0;
    return grid_.orient(corners()[0], corners()[1], corners()[2], v) >= 0 ? 1 : -1;
  }

  /// Around (s, t) in positive order the facet lies where below turns to above.
  Beyond look_beyond(std::uint32_t s, std::uint32_t t) {
    const std::uint32_t tet = grid_.tet_with_edge(s, t);
    if (tet == kNothing) fail();
    grid_.shell(tet, s, t, shell_);
    const std::size_t n = shell_.ring.size();
    for (std::size_t i = 0; i < n; ++i) {
      if (level(shell_.ring[i]) >= 0) continue;
      std::size_t j = 1;
      while (j < n && level(shell_.ring[(i + j) % n]) == 0) ++j;
      if (level(shell_.ring[(i + j) % n]) <= 0) continue;
      const std::uint32_t first = shell_.ring[(i + 1) % n];
      if (j == 1) return {kNothing, shell_.ring[i], first, shell_.tets[i]};
      if (!taken(shell_.tets[i], s, t, first) && stands_left(s, t, first))
        return {first, kNothing, kNothing, shell_.tets[i]};
    }
    return look_left(s, t);
  }

  /// For where rounded Steiner points make tets of four vertices of the facet, above which nothing is
  /// "above": any vertex of the facet to the left whose face is still free.
  Beyond look_left(std::uint32_t s, std::uint32_t t) const {
    for (std::size_t i = 0; i < shell_.ring.size(); ++i) {
      const std::uint32_t v = shell_.ring[i], tet = shell_.tets[i];
      if (level(v) == 0 && !taken(tet, s, t, v) && stands_left(s, t, v)) return {v, kNothing, kNothing, tet};
    }
    fail();
  }

  bool stands_left(std::uint32_t s, std::uint32_t t, std::uint32_t v) const {
    return grid_.orient(s, t, v, apex_) > 0;
  }

  /// Whether face (s, t, v) of the tet is part of a facet already.
  bool taken(std::uint32_t tet, std::uint32_t s, std::uint32_t t, std::uint32_t v) const {
    return grid_.tets[tet].facet[face_index(tet, s, t, v)] != kNothing;
  }
  int face_index(std::uint32_t tet, std::uint32_t s, std::uint32_t t, std::uint32_t v) const {
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t w = grid_.tets[tet].v[f];
      if (w != s && w != t && w != v) return f;
    }
    return 0;
  }

  /// Face (s, t, b.vertex) belongs to the facet.
  void accept(std::uint32_t s, std::uint32_t t, const Beyond& b) {
    const int f = face_index(b.tet, s, t, b.vertex);
    if (grid_.tets[b.tet].facet[f] != kNothing) fail();
    grid_.set_facet(b.tet, f, facet_);
    front_.pop_back();
    advance_front(s, b.vertex);
    advance_front(b.vertex, t);
  }

  /// Two front edges that meet are done.
  void advance_front(std::uint32_t s, std::uint32_t t) {
    const auto at = std::find(front_.begin(), front_.end(), std::pair{t, s});
    if (at != front_.end())
      front_.erase(at);
    else
      front_.emplace_back(s, t);
  }

  bool swap_away(const Beyond& b) {
    grid_.shell(b.tet, b.below, b.above, shell_);
    return remove_edge(
        r_, b.below, b.above, r_.sliver_cost(shell_.tets) + 1,
        [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
          return r_.sliver_cost({x, y, z, b.above}) + r_.sliver_cost({y, x, z, b.below});
        },
        [&](std::uint32_t u, std::uint32_t v) { return cuts(u, v); });
  }

  /// Whether grid edge (u, v) goes through the facet.
  int cuts(std::uint32_t u, std::uint32_t v) const {
    if (level(u) * level(v) >= 0) return 0;
    const auto& [a, b, c] = corners();
    const int x = grid_.orient(u, v, a, b), y = grid_.orient(u, v, b, c), z = grid_.orient(u, v, c, a);
    return (x <= 0 && y <= 0 && z <= 0) || (x >= 0 && y >= 0 && z >= 0);
  }

  void split(const Beyond& b) {
    if (r_.edge_at.contains(Recovery::key(b.below, b.above))) fail();
    grid_.shell(b.tet, b.below, b.above, shell_);
    const std::uint32_t v = grid_.add_point({});
    const auto& p = grid_.points;
    const auto& [x, y, z] = corners();
    grid_.place_exactly(v, place_on_facet({p[x], p[y], p[z]}, grid_.place(b.below), grid_.place(b.above)));
    if (!insert_steiner(r_, shell_.tets, v)) fail();
    relax_on_facet(r_, v);
    put_on_facet(v);
    r_.steiner.push_back({v, kNothing, facet_});
  }

  [[noreturn]] void fail() const { r_.refuse_facet(facet_); }

  Recovery& r_;
  TetGrid& grid_;
  std::uint32_t facet_ = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> front_;
  std::vector<std::uint32_t> on_facet_;
  Point apex_;  ///< above the facet, for orientations in its plane
  TetGrid::EdgeShell shell_;
};

}  // namespace

void recover_facets(Recovery& r) { FacetRecovery(r).run(); }

}  // namespace weft::meshing
