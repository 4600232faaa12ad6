// A tree over the triangles' boxes; rounding may make a point of a triangle nearer than the box, which then
// counts.
#include "meshing/geometry/surface/closest_triangles.h"

#include <algorithm>
#include <utility>

#include "meshing/geometry/surface/curved_triangle.h"

namespace weft::meshing {
namespace {

Box box_around(const std::array<Point, 3>& corners) {
  Box box;
  for (const Point& corner : corners) box.include(corner);
  return box;
}

TrianglePoint closest_on(const std::array<Point, 3>& corners, const Point& p) {
  return closest_point(corners[0], corners[1], corners[2], p);
}

Vec way_from(const std::array<Point, 3>& corners, const Point& p) {
  const Barycentric at = closest_on(corners, p).at;
  return p - (at[0] * corners[0] + at[1] * corners[1] + at[2] * corners[2]);
}

}  // namespace

ClosestTriangles::ClosestTriangles(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  if (triangles_.empty()) return;
  std::vector<ClosestForest::Item> items;
  items.reserve(triangles_.size());
  for (std::uint32_t i = 0; i < triangles_.size(); ++i)
    items.push_back({box_around(triangles_[i].corners), i});
  root_ = forest_.add(items);
}

ClosestTriangles::Found ClosestTriangles::closest(const Point& p, double limit2) const {
  Found best{limit2};
  if (triangles_.empty()) return best;
  const Triangle* closest = nullptr;
  forest_.visit_within(root_, p, best.distance2, [&](std::uint32_t i) {
    const Triangle& triangle = triangles_[i];
    const double box_distance2 = box_around(triangle.corners).distance2(p);
    if (box_distance2 > best.distance2) return;
    // In this order max() is no number where the first is none, and then not before anything.
    const Found found{std::max(closest_on(triangle.corners, p).distance2, box_distance2), triangle.number};
    if (!found.before(best)) return;
    best = found;
    closest = &triangle;
  });
  if (closest) best.way = way_from(closest->corners, p);
  return best;
}

std::vector<Box> ClosestTriangles::boxes(std::size_t most) const {
  return triangles_.empty() ? std::vector<Box>{} : forest_.boxes(root_, most);
}

}  // namespace weft::meshing
