// Rounded to a grid, so that what is one direction does not depend on the order in which they come.
#include "meshing/geometry/surface/face_directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace weft::meshing {
namespace {

constexpr double kGrid = 1e-4;
constexpr double kSame = 1e-3;  // radians: a surface that turns by less lets edges be as long as itself

}  // namespace

void FaceDirections::add(std::int32_t ref, const Point& a, const Point& b, const Point& c) {
  Vec normal = cross(b - a, c - a);
  const double length = norm(normal);
  if (!(length > 0) || !std::isfinite(length)) return;
  normal = 1 / length * normal;
  Direction direction{ref, static_cast<std::int32_t>(std::lround(normal.x / kGrid)),
                      static_cast<std::int32_t>(std::lround(normal.y / kGrid)),
                      static_cast<std::int32_t>(std::lround(normal.z / kGrid))};
  const std::int32_t first = direction.x != 0 ? direction.x : direction.y != 0 ? direction.y : direction.z;
  if (first < 0) direction = {ref, -direction.x, -direction.y, -direction.z};  // whatever way it is turned
  add(direction);
}

void FaceDirections::add(const Direction& direction) {
  if (count_ > kMost) return;
  const auto end = directions_.begin() + count_;
  if (std::find(directions_.begin(), end, direction) != end) return;
  if (count_ < kMost) directions_[count_] = direction;
  ++count_;
}

void FaceDirections::merge(const FaceDirections& other) {
  if (other.count_ > kMost) count_ = kMost + 1;
  for (std::uint32_t i = 0; i < std::min(other.count_, kMost); ++i) add(other.directions_[i]);
}

bool FaceDirections::may_curve(double ridge_angle_degrees) const {
  if (count_ > kMost) return true;
  const double ridge = ridge_angle_degrees * std::numbers::pi / 180;
  const auto vector = [](const Direction& d) { return kGrid * Vec{1.0 * d.x, 1.0 * d.y, 1.0 * d.z}; };
  for (std::uint32_t i = 0; i < count_; ++i)
    for (std::uint32_t j = 0; j < i; ++j) {
      if (directions_[i].ref != directions_[j].ref) continue;
      const Vec u = vector(directions_[i]), w = vector(directions_[j]);
      const double angle = std::atan2(norm(cross(u, w)), std::abs(dot(u, w)));
      if (angle > kSame && angle <= ridge + kSame) return true;
    }
  return false;
}

bool may_curve(const MeshData& mesh, double ridge_angle_degrees) {
  FaceDirections directions;
  if (mesh.triangle_refs.size() != mesh.triangles.size()) return false;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (std::max({a, b, c}) >= mesh.points.size()) continue;
    directions.add(mesh.triangle_refs[t], mesh.points[a], mesh.points[b], mesh.points[c]);
  }
  return directions.may_curve(ridge_angle_degrees);
}

}  // namespace weft::meshing
