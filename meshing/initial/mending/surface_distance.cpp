#include "meshing/initial/mending/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace weft::meshing {
namespace {

constexpr std::size_t kLeaf = 4;

double to_segment2(const Point& p, const Point& a, const Point& b) {
  const Vec along = b - a;
  const double square = norm2(along);
  const double at = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0;
  return norm2(p - (a + at * along));
}

double to_triangle2(const Point& p, const std::array<Point, 3>& t) {
  const Vec normal = cross(t[1] - t[0], t[2] - t[0]);
  const double square = norm2(normal);
  bool above = square > 0;
  for (std::size_t k = 0; k < 3 && above; ++k)
    above = dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), normal) >= 0;
  if (above) {
    const double height = dot(p - t[0], normal);
    return height * height / square;
  }
  return std::min({to_segment2(p, t[0], t[1]), to_segment2(p, t[1], t[2]), to_segment2(p, t[2], t[0])});
}

}  // namespace

SurfaceDistance::SurfaceDistance(std::span<const Point> points, std::span<const Triangle> triangles)
    : points_(points), triangles_(triangles), order_(triangles.size()), nodes_(4 * triangles.size() + 4) {
  std::iota(order_.begin(), order_.end(), 0u);
  build(1, 0, order_.size());
}

std::array<Point, 3> SurfaceDistance::corners(std::uint32_t t) const {
  const auto& v = triangles_[t];
  return {points_[v[0]], points_[v[1]], points_[v[2]]};
}

void SurfaceDistance::build(std::size_t node, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i)
    for (const Point& p : corners(order_[i])) nodes_[node].include(p);
  if (end - begin <= kLeaf) return;
  const Vec size = nodes_[node].size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto where = [&](std::uint32_t t) {
    const auto [a, b, c] = corners(t);
    return a[axis] + b[axis] + c[axis];
  };
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    const double x = where(a), y = where(b);
    return x != y ? x < y : a < b;
  });
  build(2 * node, begin, middle);
  build(2 * node + 1, middle, end);
}

/// `best` is a squared distance.
void SurfaceDistance::descend(std::size_t node, std::size_t begin, std::size_t end, const Point& p,
                              double& best) const {
  if (nodes_[node].distance2(p) >= best) return;
  if (end - begin <= kLeaf) {
    for (std::size_t i = begin; i < end; ++i) best = std::min(best, to_triangle2(p, corners(order_[i])));
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const bool left_first = nodes_[2 * node].distance2(p) <= nodes_[2 * node + 1].distance2(p);
  if (left_first) descend(2 * node, begin, middle, p, best);
  descend(2 * node + 1, middle, end, p, best);
  if (!left_first) descend(2 * node, begin, middle, p, best);
}

double SurfaceDistance::from(const Point& p) const {
  double best = std::numeric_limits<double>::infinity();
  descend(1, 0, order_.size(), p, best);
  return std::sqrt(best);
}

double SurfaceDistance::from(const std::array<Point, 3>& t) const {
  double most = from((1.0 / 3) * (t[0] + t[1] + t[2]));
  for (std::size_t k = 0; k < 3; ++k)
    most = std::max({most, from(t[k]), from(midpoint(t[k], t[(k + 1) % 3]))});
  return most;
}

}  // namespace weft::meshing
