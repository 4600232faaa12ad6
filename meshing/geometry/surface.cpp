// The reference geometry's queries: where a walk starts, the walk, and the point it ends on.
#include "meshing/geometry/surface.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "meshing/geometry/closest_tree.h"
#include "meshing/geometry/curved_triangle.h"
#include "meshing/geometry/surface_shape.h"
#include "meshing/geometry/surface_topology.h"

namespace weft::meshing {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A walk gets strictly closer with every step; this only bounds what a broken hint can cost.
constexpr int kMaxSteps = 100000;

// Seen from the hollow side of the slight kink between two curved triangles, each may have a closest point of
// its own near it: this close to an edge, in weights, both are looked at, so that the answer does not hang on
// the hint.
constexpr double kKinkMargin = 0.02;

/// A place on a patch: a triangle and the closest point in it.
struct Place {
  std::uint32_t triangle = kNone;
  TrianglePoint point{{}, kInfinity};
};

}  // namespace

struct Surface::Impl {
  Impl(const MeshData& mesh, const Options& options);

  // Points of the input; only those of triangles are read.
  std::vector<Point> points;
  SurfaceTopology topology;
  SurfaceShape shape;
  std::vector<std::uint32_t> patch_triangle;  // patch -> a triangle of it
  ClosestForest triangle_forest, edge_forest;
  std::vector<std::uint32_t> patch_root, curve_root;  // kNone where planar or straight

  void build_triangle_forest();
  void build_edge_forest();

  OnSurface project_to_plane(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  OnSurface project_to_curved(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  TrianglePoint closest_flat(std::uint32_t triangle, const Point& p) const;
  CurvedTriangle curved(std::uint32_t triangle) const;
  Vec lent_normal(std::uint32_t triangle) const;
  std::uint32_t start_triangle(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  template <class Closest>
  Place descend(Place place, double margin, const Closest& closest) const;
  template <class Closest>
  Place closest_across(const Place& place, int edge, const Closest& closest) const;
  template <class Closest>
  Place best_around(const Place& place, int corner, const Closest& closest) const;

  OnCurve project_to_line(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  CubicArc arc_at(CurveId curve, std::uint32_t place) const;
  std::uint32_t start_place(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  double edge_distance2(std::uint32_t feature, const Point& p) const;
};

Surface::Impl::Impl(const MeshData& mesh, const Options& options)
    : points(mesh.points), topology(build_surface_topology(mesh, options.ridge_angle_degrees)) {
  shape = build_surface_shape(points, topology);
  patch_triangle.assign(shape.patches.size(), kNone);
  for (std::uint32_t t = 0; t < topology.triangles.size(); ++t) {
    std::uint32_t& first = patch_triangle[topology.triangle_patch[t].value];
    first = std::min(first, t);
  }
  build_triangle_forest();
  build_edge_forest();
}

void Surface::Impl::build_triangle_forest() {
  std::vector<std::vector<ClosestForest::Item>> items(shape.patches.size());
  for (std::uint32_t t = 0; t < topology.triangles.size(); ++t) {
    const std::uint32_t patch = topology.triangle_patch[t].value;
    if (shape.patches[patch].planar) continue;
    Box box;
    for (std::uint32_t v : topology.triangles[t]) box.include(points[v]);
    items[patch].push_back({box, t});
  }
  for (auto& set : items) patch_root.push_back(set.empty() ? kNone : triangle_forest.add(set));
}

void Surface::Impl::build_edge_forest() {
  std::vector<ClosestForest::Item> items;
  for (std::uint32_t c = 0; c < topology.curves.size(); ++c) {
    items.clear();
    for (std::uint32_t f : topology.chain(CurveId(c))) {
      Box box;
      for (std::uint32_t v : topology.features[f].vertices) box.include(points[v]);
      items.push_back({box, f});
    }
    curve_root.push_back(edge_forest.add(items));
  }
}

// ---- patches

Surface::OnSurface Surface::Impl::project_to_plane(PatchId patch, const Point& p, VertexKind kind,
                                                   std::uint32_t hint) const {
  const Plane& plane = shape.planes[patch.value];
  const bool in_patch = kind == VertexKind::surface && hint < topology.triangles.size() &&
                        topology.triangle_patch[hint] == patch;
  OnSurface result{p, plane.normal, in_patch ? hint : patch_triangle[patch.value]};
  const double height = dot(plane.normal, p - plane.point);
  if (std::abs(height) <= plane.rounding) return result;
  result.x = p - height * plane.normal;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(plane.normal[i]) == 1) result.x[i] = plane.point[i];
  }
  return result;
}

TrianglePoint Surface::Impl::closest_flat(std::uint32_t triangle, const Point& p) const {
  const auto& v = topology.triangles[triangle];
  return closest_point(points[v[0]], points[v[1]], points[v[2]], p);
}

CurvedTriangle Surface::Impl::curved(std::uint32_t triangle) const {
  const auto& v = topology.triangles[triangle];
  std::array<std::array<Vec, 2>, 3> handles;
  for (int i = 0; i < 3; ++i) {
    const auto& h = shape.handles[topology.triangle_edges[triangle][i]];
    const bool forward = v[(i + 1) % 3] < v[(i + 2) % 3];
    handles[i] = forward ? h : std::array<Vec, 2>{h[1], h[0]};
  }
  return CurvedTriangle({points[v[0]], points[v[1]], points[v[2]]}, handles);
}

// Where the surface has no normal (a triangle without area, the tip of a cone) a vertex of the triangle lends
// its own.
Vec Surface::Impl::lent_normal(std::uint32_t triangle) const {
  for (std::uint32_t fan : topology.triangle_fans[triangle]) {
    if (topology.fans[fan].normal != Vec{}) return topology.fans[fan].normal;
  }
  return {0, 0, 1};
}

std::uint32_t Surface::Impl::start_triangle(PatchId patch, const Point& p, VertexKind kind,
                                            std::uint32_t hint) const {
  std::uint32_t best = kNone;
  double best_distance2 = kInfinity;
  const auto offer = [&](std::uint32_t t) {
    if (topology.triangle_patch[t] != patch) return;
    const double d2 = closest_flat(t, p).distance2;
    if (d2 < best_distance2) best = t, best_distance2 = d2;
  };
  if (kind == VertexKind::surface && hint < topology.triangles.size() &&
      topology.triangle_patch[hint] == patch) {
    return hint;
  }
  if (kind == VertexKind::ridge && hint < topology.features.size()) {
    for (std::uint32_t t : topology.triangles_at(hint)) offer(t);
  } else if (kind == VertexKind::corner) {
    const auto& list = topology.corner_triangles;
    for (auto i = std::lower_bound(list.begin(), list.end(), std::pair{hint, 0u});
         i != list.end() && i->first == hint; ++i) {
      offer(i->second);
    }
  }
  if (best != kNone) return best;
  return triangle_forest.closest(patch_root[patch.value], p,
                                 [&](std::uint32_t t) { return closest_flat(t, p).distance2; });
}

/// Moves to neighbours as long as one is closer. `closest(triangle, start)` is the closest point in a
/// triangle; only where it lies within `margin` of the border of its triangle (in weights) may a neighbour
/// have a closer one.
template <class Closest>
Place Surface::Impl::descend(Place place, double margin, const Closest& closest) const {
  for (int step = 0; step < kMaxSteps; ++step) {
    const Barycentric& at = place.point.at;
    Place next;
    for (int i = 0; i < 3; ++i) {
      const double bj = at[(i + 1) % 3], bk = at[(i + 2) % 3];
      if (bj <= margin && bk <= margin) {
        next = best_around(place, i, closest);
      } else if (at[i] <= margin && bj > margin && bk > margin) {
        next = closest_across(place, i, closest);
      }
    }
    if (!(next.point.distance2 < place.point.distance2)) return place;
    place = next;
  }
  return place;
}

/// The closest place in the triangle across an edge.
template <class Closest>
Place Surface::Impl::closest_across(const Place& place, int edge, const Closest& closest) const {
  const std::uint32_t n = topology.neighbors[place.triangle][edge];
  if (n == kNone) return {};
  const auto& v = topology.triangles[place.triangle];
  const int j = (edge + 1) % 3, k = (edge + 2) % 3;
  const double share = place.point.at[k] / (place.point.at[j] + place.point.at[k]);
  Barycentric start{};
  start[corner_of(topology.triangles[n], v[j])] = 1 - share;
  start[corner_of(topology.triangles[n], v[k])] = share;
  return {n, closest(n, start)};
}

/// The closest place in the other triangles of the fan around a corner.
template <class Closest>
Place Surface::Impl::best_around(const Place& place, int corner, const Closest& closest) const {
  const std::uint32_t vertex = topology.triangles[place.triangle][corner];
  Place best;
  for (int side : {1, 2}) {
    std::uint32_t t = place.triangle;
    int i = corner;
    for (std::uint32_t n; (n = topology.neighbors[t][(i + side) % 3]) != kNone && n != place.triangle;) {
      t = n;
      i = corner_of(topology.triangles[t], vertex);
      Barycentric start{};
      start[i] = 1;
      const TrianglePoint point = closest(t, start);
      if (point.distance2 < best.point.distance2) best = {t, point};
    }
    const bool closed = topology.neighbors[t][(i + side) % 3] != kNone;
    if (closed) break;  // one way around has seen them all
  }
  return best;
}

Surface::OnSurface Surface::Impl::project_to_curved(PatchId patch, const Point& p, VertexKind kind,
                                                    std::uint32_t hint) const {
  const auto flat = [&](std::uint32_t t, const Barycentric&) { return closest_flat(t, p); };
  const auto bent = [&](std::uint32_t t, const Barycentric& start) { return curved(t).closest(p, start); };
  Place place;
  place.triangle = start_triangle(patch, p, kind, hint);
  place.point = closest_flat(place.triangle, p);
  place = descend(place, 0, flat);
  place.point = bent(place.triangle, place.point.at);
  place = descend(place, kKinkMargin, bent);
  const auto [x, normal] = curved(place.triangle).frame(place.point.at);
  return {x, normal == Vec{} ? lent_normal(place.triangle) : normal, place.triangle};
}

// ---- curves

double Surface::Impl::edge_distance2(std::uint32_t feature, const Point& p) const {
  const auto& v = topology.features[feature].vertices;
  const Vec d = points[v[1]] - points[v[0]], q = p - points[v[0]];
  const double length2 = norm2(d);
  const double s = length2 > 0 ? std::clamp(dot(q, d) / length2, 0.0, 1.0) : 0;
  return norm2(q - s * d);
}

std::uint32_t Surface::Impl::start_place(CurveId curve, const Point& p, VertexKind kind,
                                         std::uint32_t hint) const {
  if (kind == VertexKind::ridge && hint < topology.features.size() &&
      topology.features[hint].curve == curve) {
    return topology.feature_place[hint];
  }
  std::uint32_t best = kNone;
  double best_distance2 = kInfinity;
  if (kind == VertexKind::corner) {
    const auto& list = topology.corner_features;
    for (auto i = std::lower_bound(list.begin(), list.end(), std::pair{hint, 0u});
         i != list.end() && i->first == hint; ++i) {
      const double d2 = edge_distance2(i->second, p);
      if (topology.features[i->second].curve == curve && d2 < best_distance2)
        best = i->second, best_distance2 = d2;
    }
  }
  if (best == kNone) {
    best = edge_forest.closest(curve_root[curve.value], p,
                               [&](std::uint32_t f) { return edge_distance2(f, p); });
  }
  return topology.feature_place[best];
}

Surface::OnCurve Surface::Impl::project_to_line(CurveId curve, const Point& p, VertexKind kind,
                                                std::uint32_t hint) const {
  const Line& line = shape.lines[curve.value];
  const Point on_line = line.point + dot(p - line.point, line.direction) * line.direction;
  OnCurve result{norm(on_line - p) <= line.rounding ? p : on_line, line.direction};
  // Go to the edge that holds the point, for the hint.
  const auto chain = topology.chain(curve);
  const auto vertices = topology.vertices_along(curve);
  std::uint32_t i = start_place(curve, p, kind, hint) - topology.chain_begin[curve.value];
  const auto beyond = [&](std::uint32_t vertex) { return dot(p - points[vertices[vertex]], line.direction); };
  while (i + 1 < chain.size() && beyond(i + 1) > 0) ++i;
  while (i > 0 && beyond(i) < 0) --i;
  result.hint = chain[i];
  return result;
}

/// The arc of an edge of the chain, in the chain's direction.
CubicArc Surface::Impl::arc_at(CurveId curve, std::uint32_t place) const {
  const std::uint32_t a = topology.chain_vertices[place + curve.value];
  const std::uint32_t b = topology.chain_vertices[place + curve.value + 1];
  const auto& h = shape.handles[topology.feature_edge[topology.chain_features[place]]];
  return {points[a], points[b], h[a < b ? 0 : 1], h[a < b ? 1 : 0]};
}

// ---- the public face

Surface::Surface(const MeshData& mesh, const Options& options)
    : impl_(std::make_unique<Impl>(mesh, options)) {}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

std::span<const Patch> Surface::patches() const { return impl_->shape.patches; }
std::span<const Curve> Surface::curves() const { return impl_->topology.curves; }
std::span<const Surface::FeatureEdge> Surface::feature_edges() const { return impl_->topology.features; }
PatchId Surface::triangle_patch(std::uint32_t triangle) const {
  return impl_->topology.triangle_patch[triangle];
}
VertexKind Surface::vertex_kind(std::uint32_t vertex) const { return impl_->topology.vertex_kind[vertex]; }
std::uint32_t Surface::vertex_hint(std::uint32_t vertex) const { return impl_->topology.vertex_hint[vertex]; }

Surface::OnSurface Surface::project_to_patch(PatchId patch, const Point& p, VertexKind kind,
                                             std::uint32_t hint) const {
  return impl_->shape.patches[patch.value].planar ? impl_->project_to_plane(patch, p, kind, hint)
                                                  : impl_->project_to_curved(patch, p, kind, hint);
}

Surface::OnCurve Surface::project_to_curve(CurveId curve, const Point& p, VertexKind kind,
                                           std::uint32_t hint) const {
  const SurfaceTopology& topology = impl_->topology;
  if (topology.curves[curve.value].straight) return impl_->project_to_line(curve, p, kind, hint);
  const std::uint32_t begin = topology.chain_begin[curve.value], end = topology.chain_begin[curve.value + 1];
  const bool closed = topology.closed(curve);
  std::uint32_t place = impl_->start_place(curve, p, kind, hint);
  ArcPoint best = closest_point(impl_->arc_at(curve, place), p, 0.5);
  // Along the chain as long as the next arc is closer.
  for (int step = 0; step < kMaxSteps && (best.s == 0 || best.s == 1); ++step) {
    const bool forward = best.s == 1;
    std::uint32_t next = forward ? place + 1 : place - 1;
    if (forward && place + 1 == end) next = closed ? begin : kNone;
    if (!forward && place == begin) next = closed ? end - 1 : kNone;
    if (next == kNone) break;
    const ArcPoint candidate = closest_point(impl_->arc_at(curve, next), p, forward ? 0 : 1);
    if (!(candidate.distance2 < best.distance2)) break;
    best = candidate;
    place = next;
  }
  return {best.x, best.tangent, topology.chain_features[place]};
}

}  // namespace weft::meshing
