// Fits planes, and derives the control points of curved patches from vertex normals and curve
// tangents.
#include "meshing/geometry/surface/surface_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "meshing/geometry/surface/normal_fit.h"

namespace weft::meshing {
namespace {

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
  ShapeBuilder(std::span<const Point> points, std::span<const Patch> patches, std::span<const Curve> curves,
               SurfaceTopology& topology)
      : points_(points), patches_(patches), curves_(curves), s_(topology) {}

  std::vector<std::array<Vec, 2>> build() {
    if (all_flat()) return {};
    handles_.assign(s_.edges.size(), {});
    set_feature_handles();
    fit_normals();
    adjust_normals();
    set_inner_handles();
    return std::move(handles_);
  }

 private:
  bool all_flat() const {
    return std::ranges::all_of(patches_, &Patch::planar) && std::ranges::all_of(curves_, &Curve::straight);
  }
  const Vec* tangent_at(std::uint32_t feature, std::uint32_t vertex) const {
    return s_.on_curve[feature].tangent(s_.features[feature].vertices[1] == vertex);
  }
  void set_feature_handles();
  void fit_normals();
  void collect_ring(const Fan& fan);
  void adjust_normals();
  void set_inner_handles();
  std::array<Vec, 2> inner_handles(std::uint32_t edge, const Fan& a, const Fan& b) const;

  std::span<const Point> points_;
  std::span<const Patch> patches_;
  std::span<const Curve> curves_;
  SurfaceTopology& s_;
  std::vector<std::array<Vec, 2>> handles_;
  std::vector<Vec> ring_;  // of one fan, relative to its vertex
};

void ShapeBuilder::set_feature_handles() {
  for (std::uint32_t f = 0; f < s_.features.size(); ++f) {
    const auto& [low, high] = s_.features[f].vertices;
    const FeatureOnCurve& on = s_.on_curve[f];
    const double along = on.forward ? 1 : -1;
    const Vec chord = points_[high] - points_[low];
    handles_[s_.feature_edge[f]] = {circle_handle(chord, along * on.tangents[0]),
                                    circle_handle(-1.0 * chord, -along * on.tangents[1])};
  }
}

// The mean of triangle normals is off by the order of the mesh size where triangles are irregular or, at a
// feature edge, all on one side. A local fit gains an order, and is exact on spheres and cylinders.
void ShapeBuilder::fit_normals() {
  for (Fan& fan : s_.fans) {
    if (fan.peaked || fan.normal == Vec{} || patches_[s_.triangle_patch[fan.first].value].planar) continue;
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
    if (patches_[s_.triangle_patch[t].value].planar) continue;
    for (int i = 0; i < 3; ++i) {
      if (s_.neighbors[t][i] == kNone || s_.neighbors[t][i] < t) continue;
      const std::uint32_t from = s_.triangle_fans[t][(i + 1) % 3], to = s_.triangle_fans[t][(i + 2) % 3];
      if (from == kNone || to == kNone) continue;
      const Fan &a = s_.fans[from], &b = s_.fans[to];
      const std::uint32_t edge = s_.triangle_edges[t][i];
      handles_[edge] = a.vertex < b.vertex ? inner_handles(edge, a, b) : inner_handles(edge, b, a);
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

/// f(triangle, its patch) of the own triangles.
template <class F>
void for_each_own(const SurfaceTopology& s, const F& f) {
  for (std::uint32_t t = 0; t < s.triangles.size(); ++t)
    if (s.ring(t) == 0) f(t, s.triangle_patch[t].value);
}

Vec twice_area(std::span<const Point> points, const Triangle& v) {
  return cross(points[v[1]] - points[v[0]], points[v[2]] - points[v[0]]);
}

Vec normals_of(const PatchExtent& extent, const PatchSums& sums) {
  const int exponent = exponent_above(extent.greatest);
  return {sums.sums[0].value(exponent), sums.sums[1].value(exponent), sums.sums[2].value(exponent)};
}

/// A folded patch (a closed one) has a sum of normals that means nothing.
bool has_direction(const PatchExtent& extent, const PatchSums& sums) {
  return norm(normals_of(extent, sums)) > 0.5 * sums.sums[3].value(exponent_above(extent.greatest));
}

}  // namespace

void PatchExtent::add(const PatchExtent& other) {
  box.unite(other.box);
  greatest = std::max(greatest, other.greatest);
  if (other.first_triangle >= first_triangle) return;
  first_triangle = other.first_triangle;
  reference = other.reference;
}

void PatchSums::add(const PatchSums& other) {
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i].add(other.sums[i]);
}

void PatchHeights::add(const PatchHeights& other) {
  lo = std::min(lo, other.lo);
  hi = std::max(hi, other.hi);
}

std::vector<PatchExtent> PlaneFits::extents(std::span<const std::uint32_t> numbers) const {
  std::vector<PatchExtent> extents(s_.patch_refs.size());
  for_each_own(s_, [&](std::uint32_t t, std::uint32_t patch) {
    PatchExtent& extent = extents[patch];
    extent.greatest = std::max(extent.greatest, norm(twice_area(points_, s_.triangles[t])));
    for (const std::uint32_t v : s_.triangles[t]) extent.box.include(points_[v]);
    if (extent.first_triangle != kNone) return;
    extent.first_triangle = numbers.empty() ? t : numbers[t];
    extent.reference = points_[s_.triangles[t][0]];
  });
  return extents;
}

std::vector<PatchSums> PlaneFits::sums(std::span<const PatchExtent> extents) const {
  std::vector<PatchSums> sums(extents.size());
  for_each_own(s_, [&](std::uint32_t t, std::uint32_t patch) {
    const Vec n = twice_area(points_, s_.triangles[t]);
    const int exponent = exponent_above(extents[patch].greatest);
    for (int i = 0; i < 3; ++i) sums[patch].sums[static_cast<std::size_t>(i)].add(n[i], exponent);
    sums[patch].sums[3].add(norm(n), exponent);
  });
  return sums;
}

std::vector<PatchHeights> PlaneFits::heights(std::span<const Plane> planes) const {
  std::vector<PatchHeights> heights(planes.size());
  for_each_own(s_, [&](std::uint32_t t, std::uint32_t patch) {
    for (const std::uint32_t v : s_.triangles[t]) {
      const double height = dot(planes[patch].normal, points_[v] - planes[patch].point);
      heights[patch].add({height, height});
    }
  });
  return heights;
}

std::vector<Plane> planes_of(std::span<const PatchExtent> extents, std::span<const PatchSums> sums) {
  std::vector<Plane> planes;
  for (std::size_t p = 0; p < extents.size(); ++p)
    planes.push_back({extents[p].reference, on_axes(normalized(normals_of(extents[p], sums[p]))),
                      kRounding * norm(extents[p].box.size())});
  return planes;
}

std::vector<Patch> patches_of(std::span<const std::int32_t> refs, std::span<const PatchExtent> extents,
                              std::span<const PatchSums> sums, std::span<const PatchHeights> heights,
                              std::vector<Plane>& planes) {
  std::vector<Patch> patches;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const auto [lo, hi] = heights[p];
    const bool planar =
        has_direction(extents[p], sums[p]) && hi - lo <= 2 * kFlatness * norm(extents[p].box.size());
    planes[p].point += 0.5 * (lo + hi) * planes[p].normal;
    patches.push_back({refs[p], planar, planar ? planes[p].normal : Vec{}});
  }
  return patches;
}

std::vector<std::array<Vec, 2>> control_points(std::span<const Point> points, std::span<const Patch> patches,
                                               std::span<const Curve> curves, SurfaceTopology& topology) {
  return ShapeBuilder(points, patches, curves, topology).build();
}

}  // namespace weft::meshing
