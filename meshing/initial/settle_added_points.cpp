// Lifted Steiner points crowd right above the surface, in tets too flat for the kernel to get a grip on: here
// each one is merged into a neighbour or moved to where its worst tet is best.
#include <algorithm>

#include "meshing/initial/recovery.h"

namespace weft::meshing {
namespace {

class Settling {
 public:
  Settling(Recovery& r, std::uint32_t first) : grid_(r.grid), first_(first) {}

  void run() {
    constexpr int kRounds = 8;
    for (int round = 0; round < kRounds; ++round)
      for (std::uint32_t v = first_; v < grid_.points.size(); ++v)
        if (grid_.vertex_tet[v] != kNothing && gather(v) && !merge(v)) move(v);
  }

 private:
  /// The ball, its other vertices and its worst shape; false for a vertex on a facet or in good tets.
  bool gather(std::uint32_t v) {
    constexpr double kGood = 0.02;  // of TetGrid::shape; a regular tet has 0.048
    grid_.ball(v, ball_);
    link_.clear();
    worst_ = 1;
    for (const std::uint32_t t : ball_) {
      const TetGrid::Tet& tet = grid_.tets[t];
      for (int f = 0; f < 4; ++f) {
        if (tet.v[f] == v) continue;
        if (tet.facet[f] != kNothing) return false;
        link_.push_back(tet.v[f]);
      }
      worst_ = std::min(worst_, grid_.shape(tet.v));
    }
    std::sort(link_.begin(), link_.end());
    link_.erase(std::unique(link_.begin(), link_.end()), link_.end());
    return worst_ < kGood;
  }

  /// Fills the ball from the neighbour from which its worst tet is best, if none gets worse.
  bool merge(std::uint32_t v) {
    double best = worst_;
    std::uint32_t into = kNothing;
    for (const std::uint32_t w : link_) {
      const double shape = worst_from(v, w, best);
      if (shape <= best) continue;
      best = shape;
      into = w;
    }
    if (into == kNothing) return false;
    fresh_.clear();
    for (const std::uint32_t t : ball_) {
      Tet4 tet = grid_.tets[t].v;
      if (grid_.local_index(t, into) >= 0) continue;
      std::replace(tet.begin(), tet.end(), v, into);
      fresh_.push_back(tet);
    }
    grid_.replace(ball_, fresh_);
    grid_.vertex_tet[v] = kNothing;
    return true;
  }

  /// The worst shape after v has been merged into w; stops below `enough`.
  double worst_from(std::uint32_t v, std::uint32_t w, double enough) const {
    double worst = 1;
    for (const std::uint32_t t : ball_) {
      Tet4 tet = grid_.tets[t].v;
      if (grid_.local_index(t, w) >= 0) continue;
      std::replace(tet.begin(), tet.end(), v, w);
      worst = std::min(worst, grid_.shape(tet));
      if (worst <= enough) return 0;
    }
    return worst;
  }

  void move(std::uint32_t v) {
    const Point start = grid_.points[v];
    Point place = start, centre;
    for (const std::uint32_t w : link_) centre += (1.0 / double(link_.size())) * grid_.points[w];
    double best = worst_;
    for (std::size_t i = 0; i <= link_.size(); ++i) {
      const Vec way = (i < link_.size() ? grid_.points[link_[i]] : centre) - start;
      for (double step = i < link_.size() ? 0.5 : 1; step > 1e-3; step *= 0.5) {
        grid_.points[v] = start + step * way;
        const double shape = worst_of_ball(best);
        if (shape <= best) continue;
        best = shape;
        place = grid_.points[v];
      }
    }
    grid_.points[v] = place;
  }

  double worst_of_ball(double enough) const {
    double worst = 1;
    for (const std::uint32_t t : ball_) {
      worst = std::min(worst, grid_.shape(grid_.tets[t].v));
      if (worst <= enough) return 0;
    }
    return worst;
  }

  TetGrid& grid_;
  std::uint32_t first_;
  std::vector<std::uint32_t> ball_, link_;
  std::vector<Tet4> fresh_;
  double worst_ = 0;
};

}  // namespace

void settle_added_points(Recovery& r, std::uint32_t first) { Settling(r, first).run(); }

}  // namespace weft::meshing
