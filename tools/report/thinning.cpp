#include "tools/report/thinning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "tools/report/flat_index.h"

namespace weft::report {
namespace {

/// In maps to new numbers: no number yet, or none any more.
constexpr std::uint32_t kUnnumbered = std::numeric_limits<std::uint32_t>::max();

/// The points of some triangles, as vertices of a grid: one a cell, numbered as they are met.
class GridVertices {
 public:
  GridVertices(const Triangles& triangles, const meshing::Box& box, double cell)
      : old_points_(triangles.points),
        lo_(box.lo),
        cells_in_one_(1 / cell),
        old_to_new_(triangles.points.size(), kUnnumbered),
        numbers_(triangles.corners.size() / 2) {}  // of a surface, as Euler says

  /// Of the old point `old`. A point is looked up once, however many triangles have it.
  std::uint32_t number_of(std::uint32_t old) {
    std::uint32_t& number = old_to_new_[old];
    if (number == kUnnumbered) {
      number = numbers_.number_of(cell_of(old_points_[old]));
      if (number == points_.size()) points_.push_back(old_points_[old]);
    }
    return number;
  }
  std::vector<Corner> take_points() { return std::move(points_); }

 private:
  std::array<std::int32_t, 3> cell_of(const Corner& point) const {
    const auto place = [&](double x, double lo) {
      return static_cast<std::int32_t>(std::floor((x - lo) * cells_in_one_));
    };
    return {place(point[0], lo_.x), place(point[1], lo_.y), place(point[2], lo_.z)};
  }

  const std::vector<Corner>& old_points_;
  const meshing::Point lo_;
  const double cells_in_one_;
  std::vector<std::uint32_t> old_to_new_;
  FlatIndex<std::int32_t, 3> numbers_;
  std::vector<Corner> points_;
};

std::array<std::uint32_t, 3> sorted(std::array<std::uint32_t, 3> v) {
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  if (v[1] > v[2]) std::swap(v[1], v[2]);
  if (v[0] > v[1]) std::swap(v[0], v[1]);
  return v;
}

/// Old triangles -> new ones, kUnnumbered for what has collapsed; `triangles` become the new ones.
std::vector<std::uint32_t> join(Triangles& triangles, const meshing::Box& box, double cell) {
  GridVertices vertices(triangles, box, cell);
  FlatIndex<std::uint32_t, 3> known(triangles.corners.size());
  std::vector<std::uint32_t> old_to_new(triangles.corners.size(), kUnnumbered);
  std::vector<std::array<std::uint32_t, 3>> left;
  for (std::size_t t = 0; t < old_to_new.size(); ++t) {
    std::array<std::uint32_t, 3> v = triangles.corners[t];
    for (std::uint32_t& vertex : v) vertex = vertices.number_of(vertex);
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    old_to_new[t] = known.number_of(sorted(v));
    if (old_to_new[t] == left.size()) left.push_back(v);
  }
  triangles = {vertices.take_points(), std::move(left)};
  return old_to_new;
}

/// Makes `in_left` name the new triangles, and drops from both lists what has collapsed.
void follow(const std::vector<std::uint32_t>& old_to_new, Thinning& thinning) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < thinning.kept.size(); ++i) {
    const std::uint32_t now = old_to_new[thinning.in_left[i]];
    if (now == kUnnumbered) continue;
    thinning.kept[n] = thinning.kept[i];
    thinning.in_left[n++] = now;
  }
  thinning.kept.resize(n);
  thinning.in_left.resize(n);
}

}  // namespace

Thinning thinned_out(Triangles triangles, const meshing::Box& box, std::size_t most) {
  constexpr double kLeastStep = 1.1;
  Thinning thinning;
  thinning.left = std::move(triangles);
  std::vector<std::array<std::uint32_t, 3>>& left = thinning.left.corners;
  thinning.kept.resize(left.size());
  std::iota(thinning.kept.begin(), thinning.kept.end(), 0u);
  thinning.in_left = thinning.kept;
  const meshing::Vec size = box.size();
  double cell = std::max({size.x, size.y, size.z}) / 1024;
  // On a surface the number of triangles goes at most with the square of the cells' size, once these are
  // larger than the triangles: the step to the next grid is as large as that allows.
  while (left.size() > most) {
    follow(join(thinning.left, box, cell), thinning);
    thinning.thinned = true;
    const double excess = static_cast<double>(left.size()) / static_cast<double>(most);
    cell *= std::max(kLeastStep, std::sqrt(excess));
  }
  return thinning;
}

}  // namespace weft::report
