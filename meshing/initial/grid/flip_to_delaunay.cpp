// Flips (Joe 1991) that are right whatever the rounding: each lowers the surface over the points lifted to a
// paraboloid, so they come to an end.
#include "meshing/initial/grid/flip_to_delaunay.h"

#include <algorithm>
#include <cmath>

#include "meshing/base/parallel.h"

namespace weft::meshing {
namespace {

/// Whether e is within the circumsphere of the positive tet by more than what rounding makes of the
/// determinant: 24 products of an edge's square and three coordinates, each off by 16 units in the last place
/// at most (Shewchuk 1997). Spheres that nearly go through e need no flip.
bool surely_in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  const Vec u = a - e, v = b - e, w = c - e, x = d - e;
  const double uu = norm2(u), vv = norm2(v), ww = norm2(w), xx = norm2(x);
  const Vec uv = cross(u, v), wx = cross(w, x);
  const double det = uu * dot(v, wx) - vv * dot(u, wx) + ww * dot(x, uv) - xx * dot(w, uv);
  const double longest2 = std::max({uu, vv, ww, xx});
  return det > 1e-13 * longest2 * longest2 * std::sqrt(longest2);
}

class Flips {
 public:
  explicit Flips(TetGrid& grid) : grid_(grid) {}

  void run(const std::atomic<bool>* interrupt) {
    enqueue_all();
    for (std::size_t i = 0; i < queue_.size() && !(interrupt && *interrupt); ++i) visit(queue_[i]);
  }

 private:
  void enqueue_all() {
    std::vector<char> waits(grid_.tets.size());
    for_each_index(waits.size(), [&](std::size_t i) {
      const auto t = static_cast<std::uint32_t>(i);
      for (int f = 0; f < 4 && grid_.alive(t) && !waits[t]; ++f)
        waits[t] = t < grid_.tets[t].n[f] >> 2 && conflicts(t, f);
    });
    for (std::uint32_t t = 0; t < waits.size(); ++t)
      if (waits[t]) queue_.push_back(t);
  }

  /// Whether the vertex beyond a face is within the circumsphere.
  bool conflicts(std::uint32_t t, int f) const {
    const TetGrid::Tet& tet = grid_.tets[t];
    if (tet.n[f] == kNothing || tet.facet[f] != kNothing) return false;
    const auto& p = grid_.points;
    return surely_in_sphere(p[tet.v[0]], p[tet.v[1]], p[tet.v[2]], p[tet.v[3]], p[apex_beyond(t, f)]);
  }

  std::uint32_t apex_beyond(std::uint32_t t, int f) const {
    const std::uint32_t n = grid_.tets[t].n[f];
    return grid_.tets[n >> 2].v[n & 3];
  }

  void visit(std::uint32_t t) {
    if (!grid_.alive(t)) return;
    for (int f = 0; f < 4; ++f)
      if (conflicts(t, f) && flip(t, f)) return;
  }

  bool flip(std::uint32_t t, int f) {
    const Face3 w = grid_.face(t, f);
    const std::uint32_t above = grid_.tets[t].v[f], below = apex_beyond(t, f);
    shell_.tets = {t, grid_.tets[t].n[f] >> 2};
    fresh_.clear();
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = w[i], b = w[(i + 1) % 3];
      const int side = grid_.orient(a, b, below, above);
      if (side > 0)
        fresh_.push_back({a, b, below, above});
      else if (shell_.tets.size() > 2 || !removes(t, a, b, side == 0 ? 4 : 3) ||
               (side == 0 && !add_other_half(a, b, w, below, above)))
        return false;
    }
    const auto slots = grid_.replace(shell_.tets, fresh_);
    queue_.insert(queue_.end(), slots.begin(), slots.end());
    return true;
  }

  /// Whether the edge, which the line from above to below passes or meets, has so many tets around it and no
  /// facet between them.
  bool removes(std::uint32_t t, std::uint32_t a, std::uint32_t b, std::size_t tets) {
    grid_.shell(t, a, b, shell_);
    if (!shell_.closed || shell_.tets.size() != tets) return false;
    for (const std::uint32_t s : shell_.tets)
      for (const std::uint32_t v : shell_.ring)
        if (const int f = grid_.local_index(s, v); f >= 0 && grid_.tets[s].facet[f] != kNothing) return false;
    return true;
  }

  /// Where line and edge meet, there are two tets on its other side, which are exchanged too.
  bool add_other_half(std::uint32_t a, std::uint32_t b, const Face3& w, std::uint32_t below,
                      std::uint32_t above) {
    const auto x = std::ranges::find_if(shell_.ring, [&](std::uint32_t v) {
      return v != below && v != above && v != w[0] && v != w[1] && v != w[2];
    });
    fresh_.push_back({a, *x, below, above});
    fresh_.push_back({*x, b, below, above});
    return grid_.positive(fresh_.back()) && grid_.positive(fresh_[fresh_.size() - 2]);
  }

  TetGrid& grid_;
  std::vector<std::uint32_t> queue_;
  std::vector<Tet4> fresh_;
  TetGrid::EdgeShell shell_;
};

}  // namespace

void flip_to_delaunay(TetGrid& grid, const std::atomic<bool>* interrupt) { Flips(grid).run(interrupt); }

}  // namespace weft::meshing
