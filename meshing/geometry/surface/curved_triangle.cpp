// Cubic arcs and PN triangles: evaluation, and closest points by Newton's method with a few safeguards.
#include "meshing/geometry/surface/curved_triangle.h"

#include <algorithm>
#include <cmath>

namespace weft::meshing {
namespace {

constexpr int kMaxIterations = 16;
// A Newton step this small, in weights, leaves an error of its square.
constexpr double kSmallStep = 1e-8;

struct ArcJet {
  Vec x, d1, d2;
};

ArcJet evaluate(const CubicArc& arc, double s) {
  const Vec c1 = arc.handle_a, c3 = arc.b - arc.a, c2 = c3 + arc.handle_b;
  const double r = 1 - s;
  const Vec q0 = s * c1, q1 = r * c1 + s * c2, q2 = r * c2 + s * c3;
  const Vec l0 = r * q0 + s * q1, l1 = r * q1 + s * q2;
  return {r * l0 + s * l1, 3.0 * (l1 - l0), 6.0 * (q2 - q1 - (q1 - q0))};
}

}  // namespace

ArcPoint closest_point(const CubicArc& arc, const Point& p, double start) {
  const Vec q = p - arc.a;
  double s = std::clamp(start, 0.0, 1.0), last = 1;
  ArcJet jet = evaluate(arc, s);
  for (int i = 0; i < kMaxIterations && std::abs(last) > kSmallStep; ++i) {
    const Vec r = jet.x - q;
    const double speed2 = norm2(jet.d1);
    const double curved = speed2 + dot(r, jet.d2);
    const double hessian = curved > 0.1 * speed2 ? curved : speed2;
    if (!(hessian > 0)) break;
    const double next = std::clamp(s - dot(r, jet.d1) / hessian, 0.0, 1.0);
    last = next - s;
    s = next;
    jet = evaluate(arc, s);
  }
  const Point x = s == 1 ? arc.b : arc.a + jet.x;
  Vec tangent = normalized(jet.d1);
  if (tangent == Vec{}) tangent = normalized(arc.b - arc.a);
  return {s, norm2(x - p), x, tangent};
}

TrianglePoint closest_point(const Point& a, const Point& b, const Point& c, const Point& p) {
  const Vec ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const auto result = [&](double v, double w, double u) {
    return TrianglePoint{{u, v, w}, norm2(ap - v * ab - w * ac)};
  };
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return result(0, 0, 1);
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return result(1, 0, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3)  // not of two equal corners
    return result(d1 / (d1 - d3), 0, 1 - d1 / (d1 - d3));
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return result(0, 1, 0);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return result(0, d2 / (d2 - d6), 1 - d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return result(1 - w, w, 0);
  }
  const double scale = 1 / (va + vb + vc), v = vb * scale, w = vc * scale;
  return result(v, w, std::max(0.0, 1 - v - w));
}

CurvedTriangle::CurvedTriangle(const std::array<Point, 3>& corners,
                               const std::array<std::array<Vec, 2>, 3>& handles)
    : origin_(corners[0]), c030_(corners[1] - corners[0]), c003_(corners[2] - corners[0]) {
  c021_ = c030_ + handles[0][0];
  c012_ = c003_ + handles[0][1];
  c102_ = c003_ + handles[1][0];
  c201_ = handles[1][1];
  c210_ = handles[2][0];
  c120_ = c030_ + handles[2][1];
  const Vec sum = c021_ + c012_ + (c102_ + c201_) + (c210_ + c120_);
  c111_ = 0.25 * sum - (1.0 / 6) * (c030_ + c003_);  // E + (E - V) / 2: exact for quadratic surfaces
}

CurvedTriangle::Jet CurvedTriangle::evaluate(const Barycentric& at) const {
  const auto [u, v, w] = at;
  // De Casteljau: six points of degree two, three of degree one, one.
  const Vec q00 = v * c210_ + w * c201_, q01 = u * c210_ + v * c120_ + w * c111_;
  const Vec q02 = u * c201_ + v * c111_ + w * c102_, q11 = u * c120_ + v * c030_ + w * c021_;
  const Vec q12 = u * c111_ + v * c021_ + w * c012_, q22 = u * c102_ + v * c012_ + w * c003_;
  const Vec l0 = u * q00 + v * q01 + w * q02, l1 = u * q01 + v * q11 + w * q12,
            l2 = u * q02 + v * q12 + w * q22;
  return {u * l0 + v * l1 + w * l2,
          3.0 * (l1 - l0),
          3.0 * (l2 - l0),
          6.0 * (q11 - q01 - (q01 - q00)),
          6.0 * (q12 - q02 - (q01 - q00)),
          6.0 * (q22 - q02 - (q02 - q00))};
}

CurvedTriangle::Frame CurvedTriangle::frame(const Barycentric& at) const {
  const Jet jet = evaluate(at);
  const Vec n = cross(jet.d1, jet.d2);
  const double length = norm(n);
  const bool degenerate = !(length > 1e-12 * (norm2(jet.d1) + norm2(jet.d2)));
  return {origin_ + jet.x, degenerate ? Vec{} : (1 / length) * n};
}

namespace {

/// The quadratic model of half the squared distance, in the weights of corners 1 and 2.
struct QuadraticModel {
  double g1, g2, h11, h12, h22;
};

QuadraticModel model_of(const CurvedTriangle::Jet& jet, const Vec& q) {
  const Vec r = jet.x - q;
  QuadraticModel m{dot(r, jet.d1), dot(r, jet.d2), norm2(jet.d1), dot(jet.d1, jet.d2), norm2(jet.d2)};
  const double a = m.h11 + dot(r, jet.d11), b = m.h12 + dot(r, jet.d12), c = m.h22 + dot(r, jet.d22);
  // Newton's Hessian unless the point is so far from the surface that it is about to lose definiteness.
  if (a > 0 && c > 0 && a * c - b * b > 0.1 * (m.h11 * m.h22 - m.h12 * m.h12)) {
    m.h11 = a, m.h12 = b, m.h22 = c;
  }
  return m;
}

/// The step to the model's minimum over the plane, as a change of the three weights.
Barycentric free_step(const QuadraticModel& m) {
  const double det = m.h11 * m.h22 - m.h12 * m.h12, trace = m.h11 + m.h22;
  if (!(trace > 0)) return {};
  double s1 = -m.g1 / trace, s2 = -m.g2 / trace;  // of a degenerate triangle: downhill
  if (det > 1e-15 * trace * trace) {
    s1 = (m.h12 * m.g2 - m.h22 * m.g1) / det;
    s2 = (m.h12 * m.g1 - m.h11 * m.g2) / det;
  }
  return {-s1 - s2, s1, s2};
}

/// The step to the model's minimum along edge `i`.
Barycentric edge_step(const QuadraticModel& m, int i) {
  Barycentric e{};
  e[(i + 1) % 3] = -1;
  e[(i + 2) % 3] = 1;
  const double slope = e[1] * m.g1 + e[2] * m.g2;
  const double hessian = e[1] * e[1] * m.h11 + 2 * e[1] * e[2] * m.h12 + e[2] * e[2] * m.h22;
  const double s = hessian > 0 ? -slope / hessian : 0;
  return {s * e[0], s * e[1], s * e[2]};
}

bool leaves(const Barycentric& at, const Barycentric& step) {
  for (int i = 0; i < 3; ++i) {
    if (at[i] == 0 && step[i] < 0) return true;
  }
  return false;
}

/// The best step that does not leave the triangle at once: over the plane, else along an edge that `at` is
/// on.
Barycentric feasible_step(const Barycentric& at, const QuadraticModel& m) {
  Barycentric step = free_step(m);
  if (!leaves(at, step)) return step;
  for (int i = 0; i < 3; ++i) {
    if (at[i] != 0) continue;
    step = edge_step(m, i);
    if (!leaves(at, step)) return step;
  }
  return {};
}

/// at + fraction * step, stopped where a weight reaches zero (which it then is exactly).
Barycentric advance(const Barycentric& at, const Barycentric& step, double fraction) {
  int stop = -1;
  for (int i = 0; i < 3; ++i) {
    if (step[i] < 0 && at[i] + fraction * step[i] <= 0) {
      fraction = -at[i] / step[i];
      stop = i;
    }
  }
  Barycentric next;
  for (int i = 0; i < 3; ++i) next[i] = at[i] + fraction * step[i];
  if (stop >= 0) next[stop] = 0;
  const int largest = static_cast<int>(std::max_element(next.begin(), next.end()) - next.begin());
  for (double& b : next) b = std::max(b, 0.0);
  next[largest] = 1 - next[(largest + 1) % 3] - next[(largest + 2) % 3];
  return next;
}

}  // namespace

TrianglePoint CurvedTriangle::closest(const Point& p, const Barycentric& start) const {
  const Vec q = p - origin_;
  TrianglePoint best{start, 0};
  Jet jet = evaluate(start);
  best.distance2 = norm2(jet.x - q);
  for (int i = 0; i < kMaxIterations; ++i) {
    const Barycentric step = feasible_step(best.at, model_of(jet, q));
    const double size = std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2])});
    if (size == 0) break;
    // A step so small needs no check: rounding in the distance would refuse the last digits.
    double fraction = 1;
    for (int halving = 0;; ++halving, fraction *= 0.5) {
      const Barycentric next = advance(best.at, step, fraction);
      jet = evaluate(next);
      const double distance2 = norm2(jet.x - q);
      if (distance2 <= best.distance2 || size <= kSmallStep) {
        best = {next, distance2};
        break;
      }
      if (halving == 8) return best;
    }
    if (size <= kSmallStep) break;
  }
  return best;
}

}  // namespace weft::meshing
