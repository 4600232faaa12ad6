// The formulas of lines, circles and quadrics, and of tori.
#include "meshing/geometry/model/closed_forms.h"

#include <algorithm>
#include <cmath>

namespace weft::meshing {
namespace {

using Kind = SurfaceForm::Kind;

/// The radial direction at angle u and its derivative.
struct Radial {
  Radial(const Frame& f, double u)
      : out(std::cos(u) * f.x + std::sin(u) * f.y), around(std::cos(u) * f.y + -std::sin(u) * f.x) {}
  Vec out, around;
};

struct Local {
  double x, y, z;
};
Local local(const Frame& f, const Point& p) {
  const Vec d = p - f.origin;
  return {dot(d, f.x), dot(d, f.y), dot(d, f.z)};
}

SurfaceJet evaluate_cylinder(const SurfaceForm& s, const Radial& r, double v) {
  return {s.frame.origin + (s.radius * r.out + v * s.frame.z),
          s.radius * r.around,
          s.frame.z,
          -s.radius * r.out,
          {},
          {}};
}

SurfaceJet evaluate_cone(const SurfaceForm& s, const Radial& r, double v) {
  const double sine = std::sin(s.second), cosine = std::cos(s.second), radius = s.radius + v * sine;
  return {s.frame.origin + (radius * r.out + v * cosine * s.frame.z),
          radius * r.around,
          sine * r.out + cosine * s.frame.z,
          -radius * r.out,
          sine * r.around,
          {}};
}

/// A sphere is a torus whose tube has its centre on the axis.
SurfaceJet evaluate_torus(const SurfaceForm& s, const Radial& r, double v, double main, double tube) {
  const double sine = std::sin(v), cosine = std::cos(v), radius = main + tube * cosine;
  return {s.frame.origin + (radius * r.out + tube * sine * s.frame.z),
          radius * r.around,
          tube * (cosine * s.frame.z - sine * r.out),
          -radius * r.out,
          -tube * sine * r.around,
          -tube * (cosine * r.out + sine * s.frame.z)};
}

/// On the generator through the point, or where that leaves its nappe, the apex.
Parameters closest_on_cone(const SurfaceForm& s, const Local& p) {
  const double side = s.beyond_apex ? -1 : 1, sine = std::sin(s.second), cosine = std::cos(s.second);
  double v = (side * std::hypot(p.x, p.y) - s.radius) * sine + p.z * cosine;
  if (side * (s.radius + v * sine) < 0) v = -s.radius / sine;
  return {std::atan2(side * p.y, side * p.x), v};
}

double handedness(const Frame& f) { return dot(cross(f.x, f.y), f.z) < 0 ? -1 : 1; }

}  // namespace

CurveJet evaluate(const CurveForm& form, double t) {
  const Frame& f = form.frame;
  if (form.kind == CurveForm::Kind::line) return {f.origin + t * f.x, f.x, {}};
  const Radial r(f, t);
  return {f.origin + form.radius * r.out, form.radius * r.around, -form.radius * r.out};
}

SurfaceJet evaluate(const SurfaceForm& form, const Parameters& at) {
  const Frame& f = form.frame;
  const auto [u, v] = at;
  if (form.kind == Kind::plane) return {f.origin + (u * f.x + v * f.y), f.x, f.y, {}, {}, {}};
  const Radial r(f, u);
  if (form.kind == Kind::cylinder) return evaluate_cylinder(form, r, v);
  if (form.kind == Kind::cone) return evaluate_cone(form, r, v);
  if (form.kind == Kind::sphere) return evaluate_torus(form, r, v, 0, form.radius);
  return evaluate_torus(form, r, v, form.radius, form.second);
}

double closest_parameter(const CurveForm& form, const Point& p) {
  const Local q = local(form.frame, p);
  return form.kind == CurveForm::Kind::line ? q.x : std::atan2(q.y, q.x);
}

Parameters closest_parameters(const SurfaceForm& form, const Point& p) {
  const Local q = local(form.frame, p);
  if (form.kind == Kind::plane) return {q.x, q.y};
  if (form.kind == Kind::cone) return closest_on_cone(form, q);
  const double u = std::atan2(q.y, q.x), out = std::hypot(q.x, q.y);
  if (form.kind == Kind::cylinder) return {u, q.z};
  if (form.kind == Kind::sphere) return {u, std::atan2(q.z, out)};
  return {u, std::atan2(q.z, out - form.radius)};
}

Vec unit_normal(const SurfaceForm& form, const Parameters& at) {
  const Frame& f = form.frame;
  const double hand = handedness(f);
  if (form.kind == Kind::plane) return hand * f.z;
  const Radial r(f, at[0]);
  if (form.kind == Kind::cylinder) return hand * r.out;
  if (form.kind == Kind::cone) {
    const double side = form.beyond_apex ? -hand : hand;
    return side * (std::cos(form.second) * r.out - std::sin(form.second) * f.z);
  }
  return hand * (std::cos(at[1]) * r.out + std::sin(at[1]) * f.z);
}

}  // namespace weft::meshing
