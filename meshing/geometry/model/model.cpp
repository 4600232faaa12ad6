// Samples, borders in parameters, and Newton's method for closest points.
#include "meshing/geometry/model/model.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace weft::meshing {
namespace {

constexpr int kMostSteps = 50;
// A step that moves the point by less of the model's size is the last: what is left is its square.
constexpr double kStill = 1e-13;
// Squared distances that differ by less of themselves do not tell which place is closer: steps are believed.
constexpr double kSameSquare = 1e-12;
constexpr double kFlat = 1e-11;
constexpr int kBorderSegments = 32;

double at_share(double a, double b, int i, int n) { return i == n ? b : a + (b - a) * i / n; }

/// `x` moved by periods into [lo, lo + period).
double wrap(double x, double lo, double period) {
  return period > 0 ? x - period * std::floor((x - lo) / period) : x;
}

/// The same where `x` lies outside [first, last], which is one period, with its end.
double wrap_outside(double x, double first, double last, double period) {
  return x < first || x > last ? wrap(x, first, period) : x;
}

/// The samples that could hold the closest point: the nearest, and nearest ones that are not beside it.
template <class Near>
std::vector<std::size_t> nearest_samples(std::span<const Point> x, const Point& p, const Near& near) {
  constexpr std::size_t kMost = 3;
  std::vector<std::size_t> chosen;
  for (std::size_t round = 0; round < kMost; ++round) {
    std::size_t best = x.size();
    double best_distance2 = kUnbounded;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double d2 = norm2(x[i] - p);
      if (!(d2 < best_distance2)) continue;
      if (std::any_of(chosen.begin(), chosen.end(), [&](std::size_t c) { return near(c, i); })) continue;
      best = i;
      best_distance2 = d2;
    }
    if (best == x.size()) break;
    chosen.push_back(best);
  }
  return chosen;
}

/// Whether one parameter moves the point by next to nothing beside the other.
bool is_pole(const SurfaceJet& jet) {
  const double u = norm2(jet.du), v = norm2(jet.dv);
  return u < 1e-12 * v || v < 1e-12 * u;
}

/// Whether the step after one of this length moves the point by next to nothing. `last` is the length of the
/// step before where that was Newton's own, else zero: those square the error, by the same factor each.
bool is_last_step(double length, double last, double still) {
  return length <= still || length * length * length <= still * last * last;
}

/// How far a curve or a surface may bulge beyond its samples, at most by experience: a share of their box.
void enlarge(Box& box, double share, double least) {
  const double d = std::max(share * norm(box.size()), least);
  for (int i = 0; i < 3; ++i) {
    box.lo[i] -= d;
    box.hi[i] += d;
  }
}

}  // namespace

Model::Model(std::shared_ptr<const GeometryModel> geometry, double scale)
    : geometry_(std::move(geometry)), scale_(scale) {
  connect();
  take_splines();
  sample_edges();
  sample_faces();
  const auto is_border = [this](std::uint32_t e) { return !edge_faces_[e].empty(); };
  for (std::uint32_t n = 0; n < num_nodes(); ++n)
    if (std::ranges::any_of(node_edges_[n], is_border)) box_.include(node(n));
  size_ = norm(box_.size());
  trace_borders();
  find_planes_and_lines();
  find_details();
}

void Model::connect() {
  edge_faces_.resize(num_edges());
  node_edges_.resize(num_nodes());
  for (std::uint32_t f = 0; f < num_faces(); ++f)
    for (const EdgeUse& use : face(f).border) {
      auto& faces = edge_faces_[use.edge];
      if (faces.empty() || faces.back() != f) faces.push_back(f);
    }
  for (std::uint32_t e = 0; e < num_edges(); ++e)
    for (const std::uint32_t n : edge(e).nodes)
      if (n != kNoEntity && (node_edges_[n].empty() || node_edges_[n].back() != e))
        node_edges_[n].push_back(e);
}

void Model::take_splines() {
  spline_curves_.resize(num_edges());
  for (std::uint32_t e = 0; e < num_edges(); ++e)
    if (edge(e).spline) spline_curves_[e].emplace(*edge(e).spline);
  spline_surfaces_.resize(num_faces());
  for (std::uint32_t f = 0; f < num_faces(); ++f)
    if (face(f).spline) spline_surfaces_[f].emplace(*face(f).spline);
}

void Model::sample_edges() {
  edge_samples_.resize(num_edges());
  edge_boxes_.resize(num_edges());
  for (std::uint32_t e = 0; e < num_edges(); ++e) {
    const ModelEdge& m = edge(e);
    Box& box = edge_boxes_[e];
    for (const std::uint32_t n : m.nodes)
      if (n != kNoEntity) box.include(node(n));
    if (m.degenerate) continue;
    EdgeSamples& s = edge_samples_[e];
    const int n = std::clamp(6 * m.spans, 24, 600);
    for (int i = 0; i <= n; ++i) {
      s.t.push_back(at_share(m.begin, m.end, i, n));
      s.x.push_back(curve(e, s.t.back()).x);
      box.include(s.x.back());
      if (!edge_faces_[e].empty()) box_.include(s.x.back());  // others are beside the body
    }
    enlarge(box, 0.02, edge_tolerance(e));
  }
}

void Model::sample_faces() {
  face_samples_.resize(num_faces());
  face_boxes_.resize(num_faces());
  for (std::uint32_t f = 0; f < num_faces(); ++f) {
    const ModelFace& m = face(f);
    FaceSamples& s = face_samples_[f];
    for (int i = 0; i < 2; ++i) s.count[i] = std::clamp(4 * m.spans[i], 16, 160) + 1;
    for (int i = 0; i < s.count[0]; ++i)
      for (int j = 0; j < s.count[1]; ++j) {
        const Parameters at{at_share(m.lo[0], m.hi[0], i, s.count[0] - 1),
                            at_share(m.lo[1], m.hi[1], j, s.count[1] - 1)};
        s.at.push_back(at);
        s.x.push_back(surface(f, at).x);
      }
    Box& box = face_boxes_[f];
    for (const Point& x : s.x) box.include(x);
    if (m.border.empty())
      for (const Point& x : s.x) box_.include(x);
    // From a pole no parameter leads anywhere: such samples are none to begin from.
    for (std::size_t i = 0; i < s.x.size(); ++i)
      if (const SurfaceJet jet = surface(f, s.at[i]); is_pole(jet))
        s.x[i] = {kUnbounded, kUnbounded, kUnbounded};
    for (const EdgeUse& use : m.border)
      for (const Point& x : edge_samples_[use.edge].x) box.include(x);
    enlarge(box, 0.05, face_tolerance(f));
  }
}

void Model::trace_borders() {
  borders_.resize(num_faces());
  for (std::uint32_t f = 0; f < num_faces(); ++f)
    for (const EdgeUse& use : face(f).border) {
      const ModelEdge& m = edge(use.edge);
      Parameters last = geometry_->on_face(f, use, m.begin);
      for (int i = 1; i <= kBorderSegments; ++i) {
        const Parameters next = geometry_->on_face(f, use, at_share(m.begin, m.end, i, kBorderSegments));
        borders_[f].push_back({last, next});
        last = next;
      }
    }
}

void Model::find_planes_and_lines() {
  planes_.resize(num_faces());
  lines_.resize(num_edges());
  for (std::uint32_t f = 0; f < num_faces(); ++f) {
    const ModelFace& m = face(f);
    const FaceSamples& s = face_samples_[f];
    if (m.form.kind != SurfaceForm::Kind::plane && m.form.kind != SurfaceForm::Kind::other) continue;
    const OnFace middle = point_on_face(f, s.at[s.at.size() / 2]);
    const bool flat = norm(middle.normal) > 0 && std::all_of(s.x.begin(), s.x.end(), [&](const Point& x) {
                        return std::abs(dot(x - middle.x, middle.normal)) <= kFlat * size_;
                      });
    if (flat) planes_[f] = Frame{middle.x, {}, {}, middle.normal};
  }
  for (std::uint32_t e = 0; e < num_edges(); ++e) {
    const EdgeSamples& s = edge_samples_[e];
    if (edge(e).form.kind == CurveForm::Kind::circle || s.x.empty()) continue;
    const Vec along = normalized(s.x.back() - s.x.front());
    const bool straight = norm(along) > 0 && std::all_of(s.x.begin(), s.x.end(), [&](const Point& x) {
                            return norm(cross(x - s.x.front(), along)) <= kFlat * size_;
                          });
    if (straight) lines_[e] = Frame{s.x.front(), along, {}, {}};
  }
}

/// Of the samples within the border; at poles there is none.
double Model::largest_curvature(std::uint32_t f) const {
  double largest = 0;
  for (const Parameters& at : face_samples_[f].at)
    if (const auto c = is_inside(f, at) ? curvature(f, at) : std::nullopt)
      largest = std::max({largest, std::abs(c->largest), std::abs(c->least)});
  return largest;
}

void Model::find_details() {
  for (std::uint32_t f = 0; f < num_faces(); ++f) {
    const double diagonal = norm(face_boxes_[f].size()), curvature = largest_curvature(f);
    const double radius = curvature > 0 ? 1 / curvature : kUnbounded;
    const double least = radius < diagonal ? 0.01 * radius : 0;
    details_.push_back(std::max(0.0002 * diagonal, std::clamp(0.001 * diagonal, least, 0.05 * radius)));
  }
}

// ---- evaluation

std::vector<std::uint32_t> Model::bodies_at(std::span<const Point> points) const {
  std::vector<Point> own(points.begin(), points.end());
  if (scale_ != 1)
    for (Point& p : own) p = (1 / scale_) * p;
  return geometry_->bodies_at(own);
}

bool Model::has_formulas() const {
  for (std::uint32_t f = 0; f < num_faces(); ++f)
    if (!has_formula(f)) return false;
  return true;
}

CurveJet Model::curve(std::uint32_t e, double t) const {
  const ModelEdge& m = edge(e);
  CurveJet jet;
  if (m.form.kind != CurveForm::Kind::other)
    jet = evaluate(m.form, t);
  else if (const auto& spline = spline_curves_[e])
    jet = spline->evaluate(wrap_outside(t, spline->first(), spline->last(), m.period));
  else
    jet = geometry_->curve(e, t);
  if (scale_ != 1) jet = {scale_ * jet.x, scale_ * jet.d1, scale_ * jet.d2};
  return jet;
}

SurfaceJet Model::surface(std::uint32_t f, const Parameters& at) const {
  const ModelFace& m = face(f);
  SurfaceJet jet;
  if (m.form.kind != SurfaceForm::Kind::other)
    jet = evaluate(m.form, at);
  else if (const auto& spline = spline_surfaces_[f])
    jet = spline->evaluate({wrap_outside(at[0], m.first[0], m.last[0], m.period[0]),
                            wrap_outside(at[1], m.first[1], m.last[1], m.period[1])});
  else
    jet = geometry_->surface(f, at);
  if (scale_ != 1)
    jet = {scale_ * jet.x,   scale_ * jet.du,  scale_ * jet.dv,
           scale_ * jet.duu, scale_ * jet.duv, scale_ * jet.dvv};
  return jet;
}

OnEdge Model::point_on_edge(std::uint32_t e, double t) const {
  const CurveJet jet = curve(e, t);
  return {jet.x, t, normalized(jet.d1), 0};
}

OnFace Model::point_on_face(std::uint32_t f, const Parameters& at) const {
  return on_face(f, surface(f, at), at);
}

OnFace Model::on_face(std::uint32_t f, const SurfaceJet& jet, const Parameters& at) const {
  const SurfaceForm& form = face(f).form;
  if (form.kind != SurfaceForm::Kind::other) return {jet.x, at, unit_normal(form, at), 0};
  const Vec n = cross(jet.du, jet.dv);
  // Where one derivative is lost in the other's rounding there is no normal.
  const bool sound = norm(n) > 1e-10 * std::max(norm2(jet.du), norm2(jet.dv));
  return {jet.x, at, sound ? normalized(n) : Vec{}, 0};
}

std::optional<SurfaceCurvature> Model::curvature(std::uint32_t f, const Parameters& at) const {
  const SurfaceJet jet = surface(f, at);
  const Vec n = point_on_face(f, at).normal;
  // First and second fundamental forms; in an orthonormal basis of the tangent plane the shape operator is
  // symmetric.
  const double ee = norm2(jet.du), ff = dot(jet.du, jet.dv), gg = norm2(jet.dv), det = ee * gg - ff * ff;
  if (!(det > 1e-20 * std::max(ee, gg) * std::max(ee, gg)) || norm(n) == 0) return std::nullopt;
  const Vec a = normalized(jet.du), b = cross(n, a);
  // Parameters that run along a and b at unit speed.
  const double va = dot(jet.dv, a), vb = dot(jet.dv, b), su = 1 / std::sqrt(ee), sv = 1 / vb;
  const std::array<double, 2> da{su, 0}, db{-va * su * sv, sv};
  const double l = dot(jet.duu, n), m = dot(jet.duv, n), k = dot(jet.dvv, n);
  const auto second = [&](const std::array<double, 2>& p, const std::array<double, 2>& q) {
    return l * p[0] * q[0] + m * (p[0] * q[1] + p[1] * q[0]) + k * p[1] * q[1];
  };
  const double aa = second(da, da), ab = second(da, db), bb = second(db, db);
  const double middle = 0.5 * (aa + bb), half = 0.5 * (aa - bb), radius = std::hypot(half, ab);
  const double angle = 0.5 * std::atan2(ab, half);
  const Vec along = std::cos(angle) * a + std::sin(angle) * b;
  return SurfaceCurvature{middle + radius, middle - radius, along, cross(n, along), n};
}

// ---- edges

/// A parameter within the range: of a closed edge by whole periods, else at the nearer end.
double Model::in_range(std::uint32_t e, double t) const {
  const ModelEdge& m = edge(e);
  if (m.period > 0) {
    t = wrap(t, m.begin, m.period);
    // Beyond the end of an arc the nearer end is that which is fewer degrees away.
    if (t > m.end) return t - m.end < m.begin + m.period - t ? m.end : m.begin;
    return t;
  }
  return std::clamp(t, m.begin, m.end);
}

OnEdge Model::finish(std::uint32_t e, const Point& p, double t) const {
  OnEdge result = point_on_edge(e, t);
  result.distance = norm(p - result.x);
  return result;
}

OnEdge Model::closest_on_edge(std::uint32_t e, const Point& p) const {
  const ModelEdge& m = edge(e);
  if (m.degenerate) return {node(m.nodes[0]), m.begin, {}, norm(p - node(m.nodes[0]))};
  if (edge_has_formula(e))
    return finish(e, p, in_range(e, closest_parameter(m.form, scale_ == 1 ? p : (1 / scale_) * p)));
  const EdgeSamples& s = edge_samples_[e];
  OnEdge best;
  best.distance = kUnbounded;
  const auto near = [](std::size_t a, std::size_t b) { return (a > b ? a - b : b - a) <= 2; };
  for (const std::size_t i : nearest_samples(s.x, p, near)) newton(e, p, s.t[i], best);
  return best;
}

OnEdge Model::closest_on_edge(std::uint32_t e, const Point& p, double guess) const {
  if (edge(e).degenerate || edge_has_formula(e)) return closest_on_edge(e, p);
  OnEdge best;
  best.distance = kUnbounded;
  return newton(e, p, guess, best) ? best : closest_on_edge(e, p);
}

/// Newton's method on half the squared distance from `t`; `best` becomes its end if that is closer. False
/// where it did not come to rest.
bool Model::newton(std::uint32_t e, const Point& p, double t, OnEdge& best) const {
  t = in_range(e, t);
  const double still = kStill * size_;
  CurveJet jet = curve(e, t);
  double f = norm2(jet.x - p), last = 0;
  bool rests = false;
  for (int step = 0; step < kMostSteps && !rests; ++step) {
    const Vec r = jet.x - p;
    const double g = dot(r, jet.d1), speed2 = norm2(jet.d1);
    double h = speed2 + dot(r, jet.d2);
    const bool exact = h > 0.1 * speed2;
    if (!exact) h = speed2;
    if (!(h > 0)) break;
    double d = -g / h;
    const double length = std::abs(d) * std::sqrt(speed2);
    rests = is_last_step(length, last, still);
    const bool blind = rests || (exact && length * length <= kSameSquare * f);
    last = 0;
    for (int halving = 0;; ++halving, d *= 0.5) {
      const double next = in_range(e, t + d);
      const CurveJet there = curve(e, next);
      const double f_there = norm2(there.x - p);
      if (f_there < f || (blind && f_there <= f * (1 + kSameSquare) + still * still)) {
        if (exact && halving == 0) last = length;
        t = next, jet = there, f = f_there;
        break;
      }
      if (next == t || halving == 12) {
        rests = true;
        break;
      }
    }
  }
  if (std::sqrt(f) < best.distance) best = {jet.x, t, normalized(jet.d1), std::sqrt(f)};
  return rests;
}

// ---- faces

Parameters Model::wrapped(std::uint32_t f, Parameters at) const {
  const ModelFace& m = face(f);
  for (int i = 0; i < 2; ++i) at[i] = wrap(at[i], m.lo[i], m.period[i]);
  return at;
}

Parameters Model::clamped(std::uint32_t f, Parameters at) const {
  const ModelFace& m = face(f);
  for (int i = 0; i < 2; ++i)
    if (m.period[i] == 0) at[i] = std::clamp(at[i], m.first[i], m.last[i]);
  return at;
}

OnFace Model::finish(std::uint32_t f, const Point& p, const Parameters& at) const {
  OnFace result = point_on_face(f, at);
  result.distance = norm(p - result.x);
  return result;
}

OnFace Model::closest_on_face(std::uint32_t f, const Point& p) const {
  if (has_formula(f))
    return finish(f, p, wrapped(f, closest_parameters(face(f).form, scale_ == 1 ? p : (1 / scale_) * p)));
  const FaceSamples& s = face_samples_[f];
  const auto columns = static_cast<std::size_t>(s.count[1]);
  const auto near = [columns](std::size_t a, std::size_t b) {
    const auto apart = [](std::size_t i, std::size_t j) { return i > j ? i - j : j - i; };
    return apart(a / columns, b / columns) <= 2 && apart(a % columns, b % columns) <= 2;
  };
  OnFace best;
  best.distance = kUnbounded;
  for (const std::size_t i : nearest_samples(s.x, p, near)) newton(f, p, s.at[i], best);
  best.at = wrapped(f, best.at);
  return best;
}

OnFace Model::closest_on_face(std::uint32_t f, const Point& p, const Parameters& guess) const {
  if (has_formula(f)) return closest_on_face(f, p);
  OnFace best;
  best.distance = kUnbounded;
  return newton(f, p, guess, best) ? best : closest_on_face(f, p);
}

namespace {

/// The step that makes a quadratic least, among parameters that are not held; along the gradient where it is
/// no minimum. `regular`: what keeps a lost derivative (a pole) from ruling the step.
Parameters quadratic_step(double a, double b, double c, const Parameters& g,
                          const std::array<bool, 2>& held) {
  if (held[0] && held[1]) return {};
  if (held[0]) return {0, c > 0 ? -g[1] / c : 0};
  if (held[1]) return {a > 0 ? -g[0] / a : 0, 0};
  const double det = a * c - b * b;
  return {(-g[0] * c + g[1] * b) / det, (-g[1] * a + g[0] * b) / det};
}

}  // namespace

/// At a pole the parameter that means nothing may be any: the best is sought near by. True, with the new
/// place and the squared distance there, where that is closer.
bool Model::leave_pole(std::uint32_t f, const Point& p, Parameters& at, double& value) const {
  constexpr int kDirections = 24;
  const ModelFace& m = face(f);
  const SurfaceJet jet = surface(f, at);
  const std::size_t idle = norm2(jet.du) < norm2(jet.dv) ? 0 : 1, other = 1 - idle;
  const double range = m.hi[other] - m.lo[other];
  bool closer = false;
  const Parameters pole = at;
  // As near as the point itself is, and nearer.
  const double reach = std::sqrt(value) / std::max(std::sqrt(std::max(norm2(jet.du), norm2(jet.dv))), 1e-300);
  for (double share = 1; share > 1e-9; share *= 0.1)
    for (int i = 0; i < kDirections; ++i) {
      const double inwards = pole[other] - m.lo[other] < m.hi[other] - pole[other] ? 1 : -1;
      Parameters q = pole;
      q[other] += inwards * std::min(share * reach, 0.1 * range);
      q[idle] = m.lo[idle] + (m.hi[idle] - m.lo[idle]) * i / kDirections;
      const double there = norm2(surface(f, q).x - p);
      if (!(there < value)) continue;
      value = there;
      at = q;
      closer = true;
    }
  return closer;
}

bool Model::newton(std::uint32_t f, const Point& p, Parameters at, OnFace& best) const {
  const ModelFace& m = face(f);
  const double still = kStill * size_;
  at = clamped(f, at);
  SurfaceJet jet = surface(f, at);
  double value = norm2(jet.x - p), last = 0;
  bool rests = false, left_pole = false;
  for (int step = 0; step < kMostSteps && !rests; ++step) {
    const Vec r = jet.x - p;
    const Parameters g{dot(r, jet.du), dot(r, jet.dv)};
    std::array<bool, 2> held{};
    for (int i = 0; i < 2; ++i)
      held[i] = m.period[i] == 0 && ((at[i] <= m.first[i] && g[i] > 0) || (at[i] >= m.last[i] && g[i] < 0));
    const double e = norm2(jet.du), k = dot(jet.du, jet.dv), l = norm2(jet.dv);
    double a = e + dot(r, jet.duu), b = k + dot(r, jet.duv), c = l + dot(r, jet.dvv);
    const bool exact = a > 0.01 * e && c > 0.01 * l && a * c - b * b > 0.01 * e * l;
    if (!exact) {
      // Gauss and Newton, kept regular.
      const double mu = 1e-8 * std::max(e, l);
      a = e + mu, b = k, c = l + mu;
    }
    if (is_pole(jet) && !left_pole) {
      left_pole = true;
      if (leave_pole(f, p, at, value)) {
        jet = surface(f, at);
        last = 0;
        continue;
      }
    }
    Parameters d = quadratic_step(a, b, c, g, held);
    const double length = norm(d[0] * jet.du + d[1] * jet.dv);
    rests = is_last_step(length, last, still);
    const bool blind = rests || (exact && length * length <= kSameSquare * value);
    last = 0;
    for (int halving = 0;; ++halving) {
      const Parameters next = clamped(f, {at[0] + d[0], at[1] + d[1]});
      const SurfaceJet there = surface(f, next);
      const double value_there = norm2(there.x - p);
      if (value_there < value || (blind && value_there <= value * (1 + kSameSquare) + still * still)) {
        if (exact && halving == 0) last = length;
        at = next, jet = there, value = value_there;
        break;
      }
      if (next == at || halving == 12) {
        rests = true;
        break;
      }
      d = {0.5 * d[0], 0.5 * d[1]};
    }
  }
  if (std::sqrt(value) < best.distance) best = on_face(f, jet, at), best.distance = std::sqrt(value);
  return rests;
}

/// Rays along v from the point cross the border an odd number of times from inside.
bool Model::is_inside(std::uint32_t f, Parameters at) const {
  if (borders_[f].empty()) return true;
  at = wrapped(f, at);
  bool inside = false;
  for (const auto& [a, b] : borders_[f]) {
    if ((a[0] <= at[0]) == (b[0] <= at[0])) continue;
    const double v = a[1] + (b[1] - a[1]) * (at[0] - a[0]) / (b[0] - a[0]);
    if (v > at[1]) inside = !inside;
  }
  return inside;
}

OnFace Model::closest_within(std::uint32_t f, const Point& p) const {
  OnFace best = closest_on_face(f, p);
  if (is_inside(f, best.at)) return best;
  OnEdge edge_best;
  edge_best.distance = kUnbounded;
  for (const EdgeUse& use : face(f).border)
    if (const OnEdge q = closest_on_edge(use.edge, p); q.distance < edge_best.distance) edge_best = q;
  if (!(edge_best.distance < kUnbounded)) return best;
  OnFace result = closest_on_face(f, edge_best.x);
  result.x = edge_best.x;
  result.distance = edge_best.distance;
  return result;
}

}  // namespace weft::meshing
