// Walks from corner to corner, then fits lines and tangents.
#include "meshing/geometry/surface/surface_curves.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace weft::meshing {
namespace {

class CurveBuilder {
 public:
  explicit CurveBuilder(std::span<const FoundFeature> features) : features_(features) {}

  SurfaceCurves build() {
    for (std::uint32_t f = 0; f < features_.size(); ++f) {
      c_.features.push_back(features_[f].vertices);
      for (std::size_t end = 0; end < 2; ++end) ends_.push_back({features_[f].vertices[end], f, end});
    }
    std::ranges::sort(ends_, {}, [](const End& e) { return std::pair{e.vertex, e.feature}; });
    form_chains();
    c_.lines.resize(c_.curves.size());
    for (std::uint32_t c = 0; c < c_.curves.size(); ++c)
      c_.curves[c].straight = fit_line(CurveId(c), c_.lines[c]);
    find_tangents();
    return std::move(c_);
  }

 private:
  struct End {
    std::uint32_t vertex, feature;
    std::size_t end;
  };

  void form_chains();
  void walk(std::uint32_t feature, std::size_t from);
  bool is_corner(const End& e) const { return features_[e.feature].corners[e.end] != 0; }
  /// The other feature at an end that is no corner; itself where there is none.
  std::uint32_t next_of(std::uint32_t feature, std::uint32_t vertex) const;
  bool fit_line(CurveId c, Line& line) const;
  void find_tangents();
  void find_tangents(CurveId c);

  std::span<const FoundFeature> features_;
  std::vector<End> ends_;  // by vertex, then by feature
  SurfaceCurves c_;
};

void CurveBuilder::form_chains() {
  c_.place_of.assign(features_.size(), kNoName);
  c_.curve_of.assign(features_.size(), CurveId{});
  c_.chain_begin.push_back(0);
  for (const End& e : ends_)
    if (is_corner(e) && c_.place_of[e.feature] == kNoName) walk(e.feature, e.end);
  for (std::uint32_t f = 0; f < features_.size(); ++f)
    if (c_.place_of[f] == kNoName) walk(f, 0);
}

std::uint32_t CurveBuilder::next_of(std::uint32_t feature, std::uint32_t vertex) const {
  const auto at = std::ranges::equal_range(ends_, vertex, {}, &End::vertex);
  for (const End& e : at)
    if (e.feature != feature) return e.feature;
  return feature;
}

void CurveBuilder::walk(std::uint32_t feature, std::size_t from) {
  const CurveId curve(static_cast<std::uint32_t>(c_.curves.size()));
  c_.curves.push_back({features_[feature].ref, false, features_[feature].required != 0});
  const std::uint32_t first = features_[feature].vertices[from];
  c_.chain_vertices.push_back(first);
  c_.chain_points.push_back(features_[feature].ends[from]);
  const bool begins_at_corner = features_[feature].corners[from] != 0;
  for (std::size_t to = 1 - from;;) {
    const FoundFeature& f = features_[feature];
    c_.curve_of[feature] = curve;
    c_.place_of[feature] = static_cast<std::uint32_t>(c_.chain_features.size());
    c_.chain_features.push_back(feature);
    const std::uint32_t v = f.vertices[to];
    c_.chain_vertices.push_back(v);
    c_.chain_points.push_back(f.ends[to]);
    if (f.corners[to] || v == first) break;
    feature = next_of(feature, v);
    to = features_[feature].vertices[0] == v ? 1 : 0;
  }
  c_.endless.push_back(c_.chain_vertices.back() == first && !begins_at_corner);
  c_.chain_begin.push_back(static_cast<std::uint32_t>(c_.chain_features.size()));
}

bool CurveBuilder::fit_line(CurveId c, Line& line) const {
  const auto points = c_.points_along(c);
  const Point& a = points.front();
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += norm(points[i] - points[i - 1]);
  const Vec chord = points.back() - a;
  if (norm(chord) < 0.5 * length) return false;
  line = {a, on_axes(normalized(chord)), kRounding * length};
  return std::ranges::all_of(
      points, [&](const Point& p) { return norm(cross(line.direction, p - a)) <= kFlatness * length; });
}

void CurveBuilder::find_tangents() {
  c_.tangents.resize(c_.chain_vertices.size());
  for (std::uint32_t c = 0; c < c_.curves.size(); ++c) find_tangents(CurveId(c));
}

/// Tangent in b of the circle through a, b and c.
Vec tangent_inside(const Point& a, const Point& b, const Point& c) {
  const Vec in = b - a, out = c - b;
  return normalized(norm2(out) * in + norm2(in) * out);
}

void CurveBuilder::find_tangents(CurveId c) {
  const auto x = c_.points_along(c);
  const std::size_t n = x.size() - 1;
  Vec* t = c_.tangents.data() + c_.chain_begin[c.value] + c.value;
  if (c_.curves[c.value].straight) {
    std::fill(t, t + n + 1, c_.lines[c.value].direction);
    return;
  }
  for (std::size_t i = 1; i < n; ++i) t[i] = tangent_inside(x[i - 1], x[i], x[i + 1]);
  if (c_.endless[c.value]) {
    t[0] = t[n] = tangent_inside(x[n - 1], x[0], x[1]);
    return;
  }
  // At an end the circle through the last three vertices goes on: it meets a chord's ends at equal angles.
  const auto mirror = [&](const Vec& tangent, const Point& a, const Point& b) {
    const Vec chord = normalized(b - a);
    return 2 * dot(tangent, chord) * chord - tangent;
  };
  t[0] = n > 1 ? mirror(t[1], x[0], x[1]) : normalized(x[1] - x[0]);
  t[n] = n > 1 ? mirror(t[n - 1], x[n - 1], x[n]) : t[0];
}

}  // namespace

SurfaceCurves form_curves(std::span<const FoundFeature> features) { return CurveBuilder(features).build(); }

Vec on_axes(const Vec& unit) {
  Vec u = unit;
  for (int i = 0; i < 3; ++i)
    if (std::abs(u[i]) < kRounding) u[i] = 0;
  return normalized(u);
}

}  // namespace weft::meshing
