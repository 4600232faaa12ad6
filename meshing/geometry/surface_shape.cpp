// Fits planes and lines, and derives the control points of curved patches from vertex normals and curve
// tangents.
#include "meshing/geometry/surface_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "meshing/geometry/closest_tree.h"
#include "meshing/geometry/normal_fit.h"

namespace weft::meshing {
namespace {

constexpr double kFlatness = 1e-6, kRounding = 1e-12;

/// Unit vector whose components lost in rounding are exactly zero, so that axis-aligned planes and lines are
/// exact.
Vec snapped(const Vec& v) {
  Vec u = normalized(v);
  for (int i = 0; i < 3; ++i) {
    if (std::abs(u[i]) < kRounding) u[i] = 0;
  }
  return normalized(u);
}

/// The third of the chord that makes the arc leaving along unit tangent `t` closest to a circle's: a circular
/// arc that turns by 2 alpha has inner control points at 2 / (3 (1 + cos alpha)) of its chord.
Vec circle_handle(const Vec& chord, const Vec& t) {
  const double length = norm(chord);
  if (!(length > 0)) return {};
  const double cosine = std::max(0.0, dot(chord, t) / length);
  return (2.0 / 3) * length / (1 + cosine) * t;
}

class ShapeBuilder {
 public:
  ShapeBuilder(std::span<const Point> points, SurfaceTopology& topology) : points_(points), s_(topology) {}

  SurfaceShape build() {
    fit_planes();
    fit_lines();
    if (all_flat()) return std::move(shape_);
    shape_.handles.assign(s_.edges.size(), {});
    find_tangents();
    set_feature_handles();
    fit_normals();
    adjust_normals();
    set_inner_handles();
    return std::move(shape_);
  }

 private:
  void fit_planes();
  void fit_lines();
  bool fit_line(CurveId c, Line& line) const;
  bool all_flat() const {
    return std::all_of(shape_.patches.begin(), shape_.patches.end(),
                       [](const Patch& p) { return p.planar; }) &&
           std::all_of(s_.curves.begin(), s_.curves.end(), [](const Curve& c) { return c.straight; });
  }
  void find_tangents();
  Vec tangent_inside(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  const Vec* tangent_at(std::uint32_t feature, std::uint32_t vertex) const;
  void set_feature_handles();
  void fit_normals();
  void collect_ring(const Fan& fan);
  void adjust_normals();
  void set_inner_handles();
  std::array<Vec, 2> inner_handles(std::uint32_t edge, const Fan& a, const Fan& b) const;
  void set_handle(std::uint32_t edge, std::uint32_t vertex, const Vec& handle) {
    shape_.handles[edge][s_.edges[edge][0] == vertex ? 0 : 1] = handle;
  }

  std::span<const Point> points_;
  SurfaceTopology& s_;
  SurfaceShape shape_;
  std::vector<Vec> tangents_;  // of chain_vertices, along the chain
  std::vector<Vec> ring_;      // of one fan, relative to its vertex
};

void ShapeBuilder::fit_planes() {
  struct Fit {
    Box box;
    Vec sum;
    double area = 0, lo = 0, hi = 0;
    std::uint32_t reference = kNone;
  };
  std::vector<Fit> fits(s_.patch_refs.size());
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    const auto& v = s_.triangles[t];
    Fit& fit = fits[s_.triangle_patch[t].value];
    const Vec n = cross(points_[v[1]] - points_[v[0]], points_[v[2]] - points_[v[0]]);
    fit.sum += n;
    fit.area += norm(n);
    for (std::uint32_t i : v) fit.box.include(points_[i]);
    if (fit.reference == kNone) fit.reference = v[0];
  }
  for (const Fit& fit : fits) {
    shape_.planes.push_back({points_[fit.reference], snapped(fit.sum), kRounding * norm(fit.box.size())});
  }
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    Fit& fit = fits[s_.triangle_patch[t].value];
    const Plane& plane = shape_.planes[s_.triangle_patch[t].value];
    for (std::uint32_t i : s_.triangles[t]) {
      const double height = dot(plane.normal, points_[i] - plane.point);
      fit.lo = std::min(fit.lo, height);
      fit.hi = std::max(fit.hi, height);
    }
  }
  for (std::size_t p = 0; p < fits.size(); ++p) {
    const Fit& fit = fits[p];
    Plane& plane = shape_.planes[p];
    // A folded patch (a closed one) has a sum of normals that means nothing.
    const bool planar =
        norm(fit.sum) > 0.5 * fit.area && fit.hi - fit.lo <= 2 * kFlatness * norm(fit.box.size());
    plane.point += 0.5 * (fit.lo + fit.hi) * plane.normal;
    shape_.patches.push_back({s_.patch_refs[p], planar, planar ? plane.normal : Vec{}});
  }
}

void ShapeBuilder::fit_lines() {
  shape_.lines.resize(s_.curves.size());
  for (std::uint32_t c = 0; c < s_.curves.size(); ++c) {
    s_.curves[c].straight = fit_line(CurveId(c), shape_.lines[c]);
  }
}

bool ShapeBuilder::fit_line(CurveId c, Line& line) const {
  const auto vertices = s_.vertices_along(c);
  const Point& a = points_[vertices.front()];
  double length = 0;
  for (std::size_t i = 1; i < vertices.size(); ++i)
    length += norm(points_[vertices[i]] - points_[vertices[i - 1]]);
  const Vec chord = points_[vertices.back()] - a;
  if (norm(chord) < 0.5 * length) return false;
  line = {a, snapped(chord), kRounding * length};
  return std::all_of(vertices.begin(), vertices.end(), [&](std::uint32_t v) {
    return norm(cross(line.direction, points_[v] - a)) <= kFlatness * length;
  });
}

/// Tangent in b of the circle through a, b and c.
Vec ShapeBuilder::tangent_inside(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Vec in = points_[b] - points_[a], out = points_[c] - points_[b];
  return normalized(norm2(out) * in + norm2(in) * out);
}

void ShapeBuilder::find_tangents() {
  tangents_.resize(s_.chain_vertices.size());
  for (std::uint32_t c = 0; c < s_.curves.size(); ++c) {
    const auto v = s_.vertices_along(CurveId(c));
    const std::size_t n = v.size() - 1;
    Vec* t = tangents_.data() + s_.chain_begin[c] + c;
    if (s_.curves[c].straight) {
      std::fill(t, t + n + 1, shape_.lines[c].direction);
      continue;
    }
    for (std::size_t i = 1; i < n; ++i) t[i] = tangent_inside(v[i - 1], v[i], v[i + 1]);
    if (s_.closed(CurveId(c))) {
      t[0] = t[n] = tangent_inside(v[n - 1], v[0], v[1]);
      continue;
    }
    // At an end the circle through the last three vertices goes on: it meets a chord's ends at equal angles.
    const auto mirror = [&](const Vec& tangent, std::uint32_t a, std::uint32_t b) {
      const Vec chord = normalized(points_[b] - points_[a]);
      return 2 * dot(tangent, chord) * chord - tangent;
    };
    t[0] = n > 1 ? mirror(t[1], v[0], v[1]) : normalized(points_[v[1]] - points_[v[0]]);
    t[n] = n > 1 ? mirror(t[n - 1], v[n - 1], v[n]) : t[0];
  }
}

/// The curve's tangent at an end of its edge `feature`, or none where the curve is a single edge of an
/// unknown shape.
const Vec* ShapeBuilder::tangent_at(std::uint32_t feature, std::uint32_t vertex) const {
  const std::uint32_t c = s_.features[feature].curve.value, place = s_.feature_place[feature];
  if (s_.chain_begin[c + 1] - s_.chain_begin[c] == 1) return nullptr;
  const std::uint32_t first = place + c;
  return &tangents_[s_.chain_vertices[first] == vertex ? first : first + 1];
}

void ShapeBuilder::set_feature_handles() {
  for (std::uint32_t c = 0; c < s_.curves.size(); ++c) {
    for (std::uint32_t place = s_.chain_begin[c]; place < s_.chain_begin[c + 1]; ++place) {
      const std::uint32_t a = s_.chain_vertices[place + c], b = s_.chain_vertices[place + c + 1];
      const std::uint32_t edge = s_.feature_edge[s_.chain_features[place]];
      const Vec chord = points_[b] - points_[a];
      set_handle(edge, a, circle_handle(chord, tangents_[place + c]));
      set_handle(edge, b, circle_handle(-1.0 * chord, -1.0 * tangents_[place + c + 1]));
    }
  }
}

// The mean of triangle normals is off by the order of the mesh size where triangles are irregular or, at a
// feature edge, all on one side. A local fit gains an order, and is exact on spheres and cylinders.
void ShapeBuilder::fit_normals() {
  for (Fan& fan : s_.fans) {
    if (fan.peaked || fan.normal == Vec{} || shape_.patches[s_.triangle_patch[fan.first].value].planar)
      continue;
    collect_ring(fan);
    std::array<Vec, 2> tangents;
    std::size_t count = 0;
    for (std::uint32_t f : fan.borders) {
      const Vec* t = f == kNone ? nullptr : tangent_at(f, fan.vertex);
      if (t) tangents[count++] = *t;
    }
    fan.normal = improved_normal(ring_, std::span(tangents).first(count), fan.normal);
  }
}

/// The vertices of the fan's triangles and of those behind their outer edges.
void ShapeBuilder::collect_ring(const Fan& fan) {
  ring_.clear();
  const Point& center = points_[fan.vertex];
  std::uint32_t t = fan.first;
  do {
    const auto& v = s_.triangles[t];
    const int i = corner_of(v, fan.vertex);
    ring_.push_back(points_[v[(i + 1) % 3]] - center);
    if (const std::uint32_t n = s_.neighbors[t][i]; n != kNone) {
      const auto& w = s_.triangles[n];
      const int k = 3 - corner_of(w, v[(i + 1) % 3]) - corner_of(w, v[(i + 2) % 3]);
      ring_.push_back(points_[w[k]] - center);
    }
    const std::uint32_t next = s_.neighbors[t][(i + 1) % 3];
    if (next == kNone) ring_.push_back(points_[v[(i + 2) % 3]] - center);
    t = next;
  } while (t != kNone && t != fan.first);
}

// A fan between feature edges holds triangles of one side only, so its mean normal leans to that side. The
// tangents of the curves that border it are better known: the normal is made perpendicular to them.
void ShapeBuilder::adjust_normals() {
  for (Fan& fan : s_.fans) {
    if (fan.borders[0] == kNone || fan.normal == Vec{}) continue;
    const Vec* t0 = tangent_at(fan.borders[0], fan.vertex);
    const Vec* t1 = tangent_at(fan.borders[1], fan.vertex);
    if (!t0 && !t1) continue;
    Vec normal = fan.normal;
    const Vec across = t0 && t1 ? cross(*t0, *t1) : Vec{};
    if (norm(across) > 0.3) {
      normal = (dot(across, normal) < 0 ? -1.0 : 1.0) * across;
    } else {
      const Vec& t = t0 ? *t0 : *t1;
      normal = normal - dot(normal, t) * t;
    }
    normal = normalized(normal);
    if (dot(normal, fan.normal) > kTrustedCosine) fan.normal = normal;
  }
}

void ShapeBuilder::set_inner_handles() {
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    if (shape_.patches[s_.triangle_patch[t].value].planar) continue;
    for (int i = 0; i < 3; ++i) {
      if (s_.neighbors[t][i] == kNone || s_.neighbors[t][i] < t) continue;
      const Fan& a = s_.fans[s_.triangle_fans[t][(i + 1) % 3]];
      const Fan& b = s_.fans[s_.triangle_fans[t][(i + 2) % 3]];
      const std::uint32_t edge = s_.triangle_edges[t][i];
      shape_.handles[edge] = a.vertex < b.vertex ? inner_handles(edge, a, b) : inner_handles(edge, b, a);
    }
  }
}

// Vlachos' handle is the third of the chord projected into the tangent plane. Here only the chord's part
// across the axis about which the normal turns is bent, and it gets a circle's length: a geodesic of a sphere
// or a cylinder (a helix) is then met to the sixth order in its angle instead of the fourth.
std::array<Vec, 2> ShapeBuilder::inner_handles(std::uint32_t edge, const Fan& a, const Fan& b) const {
  const Vec chord = points_[s_.edges[edge][1]] - points_[s_.edges[edge][0]];
  const Vec turn = cross(a.normal, b.normal);
  const Vec axis = norm(turn) > 1e-6 ? normalized(turn) : Vec{};  // below, its direction is rounding
  const Vec along = dot(chord, axis) * axis, bent = chord - along;
  const auto handle = [&](const Fan& fan, double sign) {
    if (fan.peaked || fan.normal == Vec{}) return sign / 3 * chord;
    const Vec tangent = normalized(sign * (bent - dot(bent, fan.normal) * fan.normal));
    return sign / 3 * along + circle_handle(sign * bent, tangent);
  };
  return {handle(a, 1), handle(b, -1)};
}

}  // namespace

SurfaceShape build_surface_shape(std::span<const Point> points, SurfaceTopology& topology) {
  return ShapeBuilder(points, topology).build();
}

}  // namespace weft::meshing
