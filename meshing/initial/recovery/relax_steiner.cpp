// A point that stays where an edge met a face makes tets that are flat to rounding with the next ones: it
// moves on, within its edge or facet, to where its worst tet is best.
#include "meshing/initial/recovery/relax_steiner.h"

#include <algorithm>

namespace weft::meshing {
namespace {

class Relaxation {
 public:
  Relaxation(TetGrid& grid, std::uint32_t v) : grid_(grid), v_(v), best_place_(grid.place(v)) {
    grid.ball(v, ball_);
    best_ = worst(0);
  }

  void on_edge(double least, double most) {
    const ExactPlace start = best_place_;
    for (const double end : {least, most})
      for (double step = 0.5; step > 1e-6; step *= 0.5)
        offer(start, one_term(start.s.terms[0] + step * (end - start.s.terms[0])), {});
    grid_.place_exactly(v_, best_place_);
  }

  void on_facet() {
    constexpr std::array<std::array<int, 2>, 6> ways = {{{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};
    for (double step = 0.25; step > 1e-6; step *= 0.5) {
      const ExactPlace start = best_place_;
      for (const auto& [s, t] : ways)
        offer(start, one_term(start.s.terms[0] + s * step), one_term(start.t.terms[0] + t * step));
    }
    grid_.place_exactly(v_, best_place_);
  }

 private:
  /// Short numbers keep exact arithmetic fast.
  static Parameter one_term(double x) { return {{static_cast<double>(static_cast<float>(x)), 0, 0, 0}}; }

  void offer(const ExactPlace& start, Parameter s, Parameter t) {
    ExactPlace place = start;
    place.s = s;
    place.t = t;
    grid_.place_exactly(v_, place);
    const double shape = worst(best_);
    if (shape <= best_) return;
    best_ = shape;
    best_place_ = place;
  }

  /// The ball's worst shape; 0 where it is not above `enough`.
  double worst(double enough) const {
    double shape = 1;
    for (const std::uint32_t t : ball_) {
      shape = std::min(shape, grid_.shape_above(grid_.tets[t].v, enough));
      if (shape <= enough) return 0;
    }
    return shape;
  }

  TetGrid& grid_;
  std::uint32_t v_;
  ExactPlace best_place_;
  double best_ = 0;
  std::vector<std::uint32_t> ball_;
};

}  // namespace

void relax_on_edge(Recovery& r, std::uint32_t v, double least, double most) {
  Relaxation(r.grid, v).on_edge(least, most);
}

void relax_on_facet(Recovery& r, std::uint32_t v) { Relaxation(r.grid, v).on_facet(); }

}  // namespace weft::meshing
