// Curves and surfaces that have formulas: evaluation, closest parameters and normals, parametrised as STEP,
// OpenCASCADE and EGADS do.
#pragma once

#include <array>
#include <cstdint>

#include "meshing/base/point.h"

namespace weft::meshing {

/// u and v of a surface.
using Parameters = std::array<double, 2>;

struct CurveJet {
  Point x;
  Vec d1, d2;
};

struct SurfaceJet {
  Point x;
  Vec du, dv, duu, duv, dvv;
};

/// An orthonormal frame, right- or left-handed.
struct Frame {
  Point origin;
  Vec x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
};

struct CurveForm {
  enum class Kind : std::uint8_t {
    other,
    line,    ///< origin + t x
    circle,  ///< origin + radius (cos t x + sin t y)
  };
  Kind kind = Kind::other;
  Frame frame;
  double radius = 0;
};

/// With c = cos u x + sin u y:
struct SurfaceForm {
  enum class Kind : std::uint8_t {
    other,
    plane,     ///< origin + u x + v y
    cylinder,  ///< origin + radius c + v z
    cone,      ///< origin + (radius + v sin a) c + v cos a z, a = second
    sphere,    ///< origin + radius (cos v c + sin v z)
    torus,     ///< origin + (radius + second cos v) c + second sin v z
  };
  Kind kind = Kind::other;
  Frame frame;
  double radius = 0, second = 0;
  bool beyond_apex = false;  ///< of a cone: the nappe where radius + v sin a is negative
};

// Of forms that are not `other`.
CurveJet evaluate(const CurveForm& form, double t);
SurfaceJet evaluate(const SurfaceForm& form, const Parameters& at);
/// Parameters of the closest point; angles are those of atan2, in (-pi, pi].
double closest_parameter(const CurveForm& form, const Point& p);
Parameters closest_parameters(const SurfaceForm& form, const Point& p);
/// Unit normal du x dv, by its limit where the derivatives vanish (poles of spheres); at the apex of a cone
/// that of its generator at u.
Vec unit_normal(const SurfaceForm& form, const Parameters& at);

}  // namespace weft::meshing
