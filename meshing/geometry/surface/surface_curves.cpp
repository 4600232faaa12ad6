// Walks from corner to corner, then fits lines and tangents.
#include "meshing/geometry/surface/surface_curves.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace weft::meshing {
namespace {

/// A curve's edges one after the other, and its vertices, of which there is one more.
struct Chain {
  std::vector<std::uint32_t> features;
  std::vector<std::uint8_t> forward;  // by edge
  std::vector<Point> points;
};

class CurveBuilder {
 public:
  explicit CurveBuilder(std::span<const FoundFeature> features) : features_(features) {}

  FormedCurves build() {
    for (std::uint32_t f = 0; f < features_.size(); ++f)
      for (std::size_t end = 0; end < 2; ++end) ends_.push_back({features_[f].vertices[end], f, end});
    std::ranges::sort(ends_, {}, [](const End& e) { return std::pair{e.vertex, e.feature}; });
    formed_.of_features.resize(features_.size());
    for (const End& e : ends_)
      if (is_corner(e) && !is_placed(e.feature)) form(e);
    for (std::uint32_t f = 0; f < features_.size(); ++f)
      if (!is_placed(f)) form({features_[f].vertices[0], f, 0});
    return std::move(formed_);
  }

 private:
  struct End {
    std::uint32_t vertex, feature;
    std::size_t end;
  };

  bool is_corner(const End& e) const { return features_[e.feature].corners[e.end] != 0; }
  bool is_placed(std::uint32_t feature) const { return formed_.of_features[feature].curve.valid(); }
  /// The other feature at an end that is no corner; itself where there is none.
  std::uint32_t next_of(std::uint32_t feature, std::uint32_t vertex) const;
  void form(const End& begin);
  Chain walk(const End& begin);
  void place(const Chain& chain, const FoundCurve& found);

  std::span<const FoundFeature> features_;
  std::vector<End> ends_;  // by vertex, then by feature
  FormedCurves formed_;
};

std::uint32_t CurveBuilder::next_of(std::uint32_t feature, std::uint32_t vertex) const {
  const auto at = std::ranges::equal_range(ends_, vertex, {}, &End::vertex);
  for (const End& e : at)
    if (e.feature != feature) return e.feature;
  return feature;
}

/// From corner to corner, or once around.
Chain CurveBuilder::walk(const End& begin) {
  const CurveId curve(static_cast<std::uint32_t>(formed_.curves.size()));
  Chain chain;
  chain.points.push_back(features_[begin.feature].ends[begin.end]);
  std::uint32_t feature = begin.feature;
  for (std::size_t to = 1 - begin.end;;) {
    const FoundFeature& f = features_[feature];
    formed_.of_features[feature].curve = curve;
    chain.features.push_back(feature);
    chain.forward.push_back(to == 1);
    chain.points.push_back(f.ends[to]);
    const std::uint32_t v = f.vertices[to];
    if (f.corners[to] || v == begin.vertex) return chain;
    feature = next_of(feature, v);
    to = features_[feature].vertices[0] == v ? 1 : 0;
  }
}

/// Length, chord, and the line where all points are on one.
void fit_line(std::span<const Point> points, FoundCurve& found) {
  const Point& a = points.front();
  for (std::size_t i = 1; i < points.size(); ++i) found.length += norm(points[i] - points[i - 1]);
  found.chord = points.back() - a;
  if (norm(found.chord) < 0.5 * found.length) return;
  found.line = {a, on_axes(normalized(found.chord)), kRounding * found.length};
  found.straight = std::ranges::all_of(points, [&](const Point& p) {
    return norm(cross(found.line.direction, p - a)) <= kFlatness * found.length;
  });
}

/// Tangent in b of the circle through a, b and c.
Vec tangent_inside(const Point& a, const Point& b, const Point& c) {
  const Vec in = b - a, out = c - b;
  return normalized(norm2(out) * in + norm2(in) * out);
}

/// At the vertices of a chain.
std::vector<Vec> tangents_along(std::span<const Point> x, const FoundCurve& found) {
  const std::size_t n = x.size() - 1;
  if (found.straight) return std::vector<Vec>(n + 1, found.line.direction);
  std::vector<Vec> t(n + 1);
  for (std::size_t i = 1; i < n; ++i) t[i] = tangent_inside(x[i - 1], x[i], x[i + 1]);
  if (found.endless) {
    t[0] = t[n] = tangent_inside(x[n - 1], x[0], x[1]);
    return t;
  }
  // At an end the circle through the last three vertices goes on: it meets a chord's ends at equal angles.
  const auto mirror = [&](const Vec& tangent, const Point& a, const Point& b) {
    const Vec chord = normalized(b - a);
    return 2 * dot(tangent, chord) * chord - tangent;
  };
  t[0] = n > 1 ? mirror(t[1], x[0], x[1]) : normalized(x[1] - x[0]);
  t[n] = n > 1 ? mirror(t[n - 1], x[n - 1], x[n]) : t[0];
  return t;
}

void CurveBuilder::form(const End& begin) {
  const FoundFeature& first = features_[begin.feature];
  FoundCurve found{};
  found.begin = begin.vertex;
  found.endless = !is_corner(begin);
  found.first = first.vertices;
  found.ref = first.ref;
  found.required = first.required;
  const Chain chain = walk(begin);
  fit_line(chain.points, found);
  place(chain, found);
  formed_.curves.push_back(found);
}

void CurveBuilder::place(const Chain& chain, const FoundCurve& found) {
  const std::vector<Vec> tangents = tangents_along(chain.points, found);
  for (std::size_t i = 0; i < chain.features.size(); ++i) {
    FeatureOnCurve& f = formed_.of_features[chain.features[i]];
    f.forward = chain.forward[i];
    f.first = i == 0;
    f.alone = chain.features.size() == 1;
    f.tangents =
        f.forward ? std::array{tangents[i], tangents[i + 1]} : std::array{tangents[i + 1], tangents[i]};
  }
}

}  // namespace

FormedCurves form_curves(std::span<const FoundFeature> features) { return CurveBuilder(features).build(); }

Vec on_axes(const Vec& unit) {
  Vec u = unit;
  for (int i = 0; i < 3; ++i)
    if (std::abs(u[i]) < kRounding) u[i] = 0;
  return normalized(u);
}

}  // namespace weft::meshing
