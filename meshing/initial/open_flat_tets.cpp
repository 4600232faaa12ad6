// A tet between two facets that are nearly coplanar stays flat as long as both are its faces: the edge
// opposite the facets' common one is split, and the new point pushed into the volume.
#include <algorithm>

#include "meshing/initial/recovery.h"

namespace weft::meshing {
namespace {

class FlatTets {
 public:
  explicit FlatTets(Recovery& r) : r_(r), grid_(r.grid) {}

  void run() {
    const auto before = static_cast<std::uint32_t>(grid_.tets.size());
    for (std::uint32_t t = 0; t < before; ++t) {
      if (!grid_.alive(t) || grid_.shape(grid_.tets[t].v) > kPoor) continue;
      for (const auto& e : kTetEdges)
        if (grid_.tets[t].facet[e[0]] != kNothing && grid_.tets[t].facet[e[1]] != kNothing) {
          open(t, grid_.tets[t].v[e[0]], grid_.tets[t].v[e[1]]);
          break;
        }
    }
  }

 private:
  static constexpr double kPoor = 0.02;  ///< of TetGrid::shape; a regular tet has 0.048

  /// Splits edge (a, b) of the tet where that makes the worst tet around it better.
  void open(std::uint32_t t, std::uint32_t a, std::uint32_t b) {
    if (r_.edge_at.contains(Recovery::key(a, b))) return;
    grid_.shell(t, a, b, shell_);
    if (!shell_.closed) return;
    const std::uint32_t v = grid_.add_point({});
    find_place(a, b, v);
    if (best_ <= 10 * grid_.shape(grid_.tets[t].v)) {
      grid_.points.pop_back();
      grid_.vertex_tet.pop_back();
      return;
    }
    grid_.points[v] = place_;
    star(a, b, v);
    grid_.replace(shell_.tets, fresh_);
  }

  void star(std::uint32_t a, std::uint32_t b, std::uint32_t v) {
    fresh_.clear();
    for (const std::uint32_t t : shell_.tets)
      for (const std::uint32_t end : {a, b}) {
        Tet4 w = grid_.tets[t].v;
        std::replace(w.begin(), w.end(), end, v);
        fresh_.push_back(w);
      }
  }

  /// Looks from the edge's middle towards every vertex of its ring.
  void find_place(std::uint32_t a, std::uint32_t b, std::uint32_t v) {
    best_ = 0;
    star(a, b, v);
    const Point middle = midpoint(grid_.points[a], grid_.points[b]);
    Point centre;
    for (const std::uint32_t r : shell_.ring) centre += (1.0 / double(shell_.ring.size())) * grid_.points[r];
    for (std::size_t i = 0; i <= shell_.ring.size(); ++i) {
      const Vec way = (i < shell_.ring.size() ? grid_.points[shell_.ring[i]] : centre) - middle;
      for (double step = 0.8; step > 1e-3; step *= 0.7) {
        grid_.points[v] = middle + step * way;
        double worst = 1;
        for (const Tet4& w : fresh_)
          if (worst > best_) worst = std::min(worst, grid_.shape(w));
        if (worst <= best_) continue;
        best_ = worst;
        place_ = grid_.points[v];
      }
    }
  }

  Recovery& r_;
  TetGrid& grid_;
  TetGrid::EdgeShell shell_;
  std::vector<Tet4> fresh_;
  double best_ = 0;
  Point place_;
};

}  // namespace

void open_flat_tets(Recovery& r) { FlatTets(r).run(); }

}  // namespace weft::meshing
