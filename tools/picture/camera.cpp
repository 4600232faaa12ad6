// Directions by name, and the frame of the projection.
#include "tools/picture/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "meshing/base/box.h"

namespace weft::picture {
namespace {

using meshing::Point;
using meshing::Vec;

constexpr double kMargin = 0.03;

double degrees(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw std::invalid_argument("'" + text + "' is not a number of degrees");
  return value * std::numbers::pi / 180;
}

Vec unit(const Vec& v) {
  const double length = norm(v);
  if (!(length > 0))
    throw std::invalid_argument("the view has no direction, or the up direction is along it");
  return (1 / length) * v;
}

}  // namespace

Vec direction_named(const std::string& name) {
  if (name == "iso") return {1, -1, 1};
  const bool negative = name.starts_with("-");
  const std::string axis = name.substr(negative ? 1 : 0);
  if (axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z') {
    Vec direction;
    direction[axis[0] - 'x'] = negative ? -1 : 1;
    return direction;
  }
  const auto comma = name.find(',');
  if (comma == std::string::npos)
    throw std::invalid_argument("'" + name + "' is none of x, -x, y, -y, z, -z, iso and AZIMUTH,ELEVATION");
  const double azimuth = degrees(name.substr(0, comma)), elevation = degrees(name.substr(comma + 1));
  return {std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

Vec default_up(const Vec& toward_eye) {
  constexpr double kAlong = 1e-6;
  const bool along_z = std::hypot(toward_eye.x, toward_eye.y) <= kAlong * std::abs(toward_eye.z);
  return along_z ? Vec{0, 1, 0} : Vec{0, 0, 1};
}

Camera::Camera(const View& view, std::span<const Point> points, double width, double height, double zoom)
    : toward_eye_(unit(view.toward_eye)), middle_x_(width / 2), middle_y_(height / 2) {
  right_ = unit(cross(view.up, toward_eye_));
  up_ = cross(toward_eye_, right_);
  meshing::Box extent;  // along right, up and towards the eye
  for (const Point& p : points) extent.include({dot(p, right_), dot(p, up_), dot(p, toward_eye_)});
  if (points.empty()) return;
  const Point middle = midpoint(extent.lo, extent.hi);
  centre_ = middle.x * right_ + middle.y * up_ + middle.z * toward_eye_;
  const Vec size = extent.size();
  const double usable = 1 - 2 * kMargin;
  const double fit =
      std::min(size.x > 0 ? width / size.x : HUGE_VAL, size.y > 0 ? height / size.y : HUGE_VAL);
  if (std::isfinite(fit)) scale_ = usable * fit * zoom;
}

Projected Camera::turn(const Vec& direction) const {
  return {dot(direction, right_), -dot(direction, up_), -dot(direction, toward_eye_)};
}

Projected Camera::project(const Point& p) const {
  const Projected at = turn(p - centre_);
  return {middle_x_ + scale_ * at.x, middle_y_ + scale_ * at.y, scale_ * at.depth};
}

}  // namespace weft::picture
