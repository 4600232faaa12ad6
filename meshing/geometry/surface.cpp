// The reference geometry's queries: where a walk starts, the walk, and the point it ends on.
#include "meshing/geometry/surface.h"

#include <algorithm>
#include <limits>
#include <map>
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

/// References that also tell the face or edge of the model: each pair gets a number, 0 for (0, none).
class JointRefs {
 public:
  std::int32_t number(std::int32_t ref, std::uint32_t entity) {
    const auto [at, fresh] =
        numbers_.emplace(std::pair{ref, entity}, static_cast<std::int32_t>(pairs_.size()));
    if (fresh) pairs_.push_back(at->first);
    return at->second;
  }
  std::int32_t ref(std::int32_t number) const { return pairs_[static_cast<std::size_t>(number)].first; }
  std::uint32_t entity(std::int32_t number) const { return pairs_[static_cast<std::size_t>(number)].second; }
  std::vector<bool> on_model() const {
    std::vector<bool> result;
    for (const auto& [ref, entity] : pairs_) result.push_back(entity != kNoEntity);
    return result;
  }

 private:
  std::map<std::pair<std::int32_t, std::uint32_t>, std::int32_t> numbers_{{{0, kNoEntity}, 0}};
  std::vector<std::pair<std::int32_t, std::uint32_t>> pairs_{{0, kNoEntity}};
};

/// What the surface keeps of a classification, by its own patches and curves.
struct OnModel {
  ModelClassification classification;
  JointRefs triangle_refs, edge_refs;
  std::vector<std::vector<std::uint32_t>> patch_faces;
  std::vector<std::uint32_t> curve_edge;
  std::vector<std::array<double, 2>> feature_t;  ///< feature edge -> parameters at its lower and upper vertex
  std::vector<std::uint32_t> curve_patch;        ///< of a curve amid one patch's faces: a patch; else kNone
  std::vector<bool> turned;                      ///< triangles whose order is not the input's
  const Model& model() const { return *classification.model; }
};

/// Components lost in rounding are exactly zero, so that axis-aligned planes and lines are exact.
Vec on_axes(const Vec& v) {
  Vec u = v;
  for (int i = 0; i < 3; ++i)
    if (std::abs(u[i]) < 1e-12) u[i] = 0;
  return normalized(u);
}

}  // namespace

struct Surface::Impl {
  Impl(const MeshData& mesh, const Options& options);
  Impl(const MeshData& mesh, const Options& options, ModelClassification&& classification);

  // Points of the input; only those of triangles are read.
  std::vector<Point> points;
  SurfaceTopology topology;
  SurfaceShape shape;
  std::vector<std::uint32_t> patch_triangle;  // patch -> a triangle of it
  ClosestForest triangle_forest, edge_forest;
  std::vector<std::uint32_t> patch_root, curve_root;  // kNone where planar or straight

  void build_triangle_forest();
  void build_edge_forest();

  std::unique_ptr<OnModel> on;  // null: all is reconstructed
  MeshData with_joint_refs(const MeshData& mesh);
  void take_patches_of_model();
  void take_curves_of_model();
  void take_plane(std::uint32_t patch);
  void take_line(std::uint32_t curve);
  bool is_on_model(PatchId patch) const { return on && !on->patch_faces[patch.value].empty(); }
  OnModelFace closest_on_faces(PatchId patch, const Point& p, VertexKind kind, std::uint32_t& hint) const;
  OnSurface project_to_model(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  OnEdge closest_on_model_edge(CurveId curve, const Point& p, VertexKind kind, std::uint32_t& hint) const;
  OnCurve project_to_model_edge(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  OnCurve project_to_curve_in_face(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  std::uint32_t walk_chain(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;

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

Surface::Impl::Impl(const MeshData& mesh, const Options& options, ModelClassification&& classification)
    : points(mesh.points), on(std::make_unique<OnModel>()) {
  on->classification = std::move(classification);
  const MeshData joint = with_joint_refs(mesh);
  topology = build_surface_topology(joint, options.ridge_angle_degrees,
                                    {on->triangle_refs.on_model(), on->edge_refs.on_model()});
  shape = build_surface_shape(points, topology);
  patch_triangle.assign(shape.patches.size(), kNone);
  for (std::uint32_t t = 0; t < topology.triangles.size(); ++t) {
    std::uint32_t& first = patch_triangle[topology.triangle_patch[t].value];
    first = std::min(first, t);
  }
  for (std::size_t t = 0; t < topology.triangles.size(); ++t)
    on->turned.push_back(topology.triangles[t] != mesh.triangles[t]);
  take_patches_of_model();
  take_curves_of_model();
  build_triangle_forest();
  build_edge_forest();
}

/// The mesh as the topology is to see it: references tell faces and edges of the model apart, edges on the
/// model's edges are listed, and so are vertices on its nodes.
MeshData Surface::Impl::with_joint_refs(const MeshData& mesh) {
  const ModelClassification& c = on->classification;
  MeshData joint = mesh;
  for (std::size_t i = 0; i < joint.triangles.size(); ++i) {
    const std::uint32_t face = c.triangle_face[i];
    joint.triangle_refs[i] =
        on->triangle_refs.number(mesh.triangle_refs[i], face == kNoEntity ? kNoEntity : c.face_group[face]);
  }
  std::vector<std::array<std::uint32_t, 2>> listed;
  for (std::size_t i = 0; i < joint.edges.size(); ++i) {
    const auto [a, b] = mesh.edges[i];
    listed.push_back({std::min(a, b), std::max(a, b)});
    const auto at =
        std::ranges::lower_bound(c.edges, listed.back(), {}, &ModelClassification::Edge::vertices);
    const bool found = at != c.edges.end() && at->vertices == listed.back();
    joint.edge_refs[i] = on->edge_refs.number(mesh.edge_refs[i], found ? at->edge : kNoEntity);
  }
  std::sort(listed.begin(), listed.end());
  for (const ModelClassification::Edge& e : c.edges) {
    if (std::binary_search(listed.begin(), listed.end(), e.vertices)) continue;
    joint.edges.push_back(e.vertices);
    joint.edge_refs.push_back(on->edge_refs.number(0, e.edge));
  }
  for (const auto& [vertex, node] : c.nodes) joint.corners.push_back(vertex);
  return joint;
}

/// The plane of the model in the place of one through the points.
void Surface::Impl::take_plane(std::uint32_t patch) {
  Patch& p = shape.patches[patch];
  Plane& plane = shape.planes[patch];
  const std::vector<std::uint32_t>& faces = on->patch_faces[patch];
  const std::optional<Frame>* frame = faces.size() == 1 ? &on->model().plane(faces[0]) : nullptr;
  p.planar = frame && *frame;
  if (!p.planar) {
    p.normal = {};
    return;
  }
  const double side = dot((*frame)->z, plane.normal) < 0 ? -1 : 1;
  plane.point = (*frame)->origin;
  p.normal = plane.normal = on_axes(side * (*frame)->z);
}

void Surface::Impl::take_patches_of_model() {
  const ModelClassification& c = on->classification;
  on->patch_faces.resize(shape.patches.size());
  for (std::uint32_t t = 0; t < topology.triangles.size(); ++t) {
    auto& faces = on->patch_faces[topology.triangle_patch[t].value];
    const std::uint32_t face = c.triangle_face[t];
    if (face != kNoEntity && std::ranges::find(faces, face) == faces.end()) faces.push_back(face);
  }
  for (std::uint32_t p = 0; p < shape.patches.size(); ++p) {
    shape.patches[p].ref = on->triangle_refs.ref(shape.patches[p].ref);
    std::ranges::sort(on->patch_faces[p]);
    for (const std::uint32_t f : on->patch_faces[p])
      shape.patches[p].detail = std::min(shape.patches[p].detail, on->model().detail(f));
    if (!on->patch_faces[p].empty()) take_plane(p);
  }
}

void Surface::Impl::take_line(std::uint32_t curve) {
  const std::optional<Frame>& frame = on->model().line(on->curve_edge[curve]);
  topology.curves[curve].straight = frame.has_value();
  if (!frame) return;
  Line& line = shape.lines[curve];
  const auto vertices = topology.vertices_along(CurveId(curve));
  const Vec chord = points[vertices.back()] - points[vertices.front()];
  line.point = frame->origin;
  line.direction = on_axes((dot(chord, frame->x) < 0 ? -1.0 : 1.0) * frame->x);
  double length = 0;
  for (std::size_t i = 1; i < vertices.size(); ++i)
    length += norm(points[vertices[i]] - points[vertices[i - 1]]);
  line.rounding = 1e-12 * length;
}

void Surface::Impl::take_curves_of_model() {
  const ModelClassification& c = on->classification;
  on->curve_edge.resize(topology.curves.size());
  on->curve_patch.assign(topology.curves.size(), kNone);
  on->feature_t.resize(topology.features.size());
  for (std::uint32_t f = 0; f < topology.features.size(); ++f) {
    const auto at = std::ranges::lower_bound(c.edges, topology.features[f].vertices, {},
                                             &ModelClassification::Edge::vertices);
    if (at != c.edges.end() && at->vertices == topology.features[f].vertices) on->feature_t[f] = at->t;
  }
  for (std::uint32_t i = 0; i < topology.curves.size(); ++i) {
    const std::int32_t number = topology.curves[i].ref;
    topology.curves[i].ref = on->edge_refs.ref(number);
    on->curve_edge[i] = on->edge_refs.entity(number);
    if (on->curve_edge[i] != kNoEntity) {
      take_line(i);
      continue;
    }
    // A curve that the user has drawn on a face: its vertices stay on the face.
    const auto at = topology.triangles_at(topology.chain(CurveId(i)).front());
    const PatchId patch = topology.triangle_patch[at[0]];
    const bool amid = std::ranges::all_of(at, [&](std::uint32_t t) {
      return on->patch_faces[topology.triangle_patch[t].value] == on->patch_faces[patch.value];
    });
    if (!amid || !is_on_model(patch) || shape.patches[patch.value].planar) continue;
    on->curve_patch[i] = patch.value;
    topology.curves[i].straight = false;
  }
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
  if (patch_root[patch.value] == kNone) return patch_triangle[patch.value];  // a flat face without a formula
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

// ---- patches on faces of the model

/// `hint` becomes that of the next query.
Surface::OnModelFace Surface::Impl::closest_on_faces(PatchId patch, const Point& p, VertexKind kind,
                                                     std::uint32_t& hint) const {
  const Model& model = on->model();
  const std::vector<std::uint32_t>& faces = on->patch_faces[patch.value];
  if (faces.size() == 1 && model.has_formula(faces[0])) {
    const bool in_patch = kind == VertexKind::surface && hint < topology.triangles.size() &&
                          topology.triangle_patch[hint] == patch;
    if (!in_patch) hint = patch_triangle[patch.value];
    return {faces[0], model.closest_on_face(faces[0], p)};
  }
  if (faces.size() > 1) {
    OnModelFace best;
    best.at.distance = kInfinity;
    for (const std::uint32_t f : faces)
      if (const OnFace q = model.closest_within(f, p); q.distance < best.at.distance) best = {f, q};
    return best;
  }
  // The input's triangles tell where to begin.
  const auto flat = [&](std::uint32_t t, const Barycentric&) { return closest_flat(t, p); };
  Place place;
  place.triangle = start_triangle(patch, p, kind, hint);
  place.point = closest_flat(place.triangle, p);
  place = descend(place, 0, flat);
  hint = place.triangle;
  const auto& corners = on->classification.parameters[place.triangle];
  // Triangles may have been turned since they were classified; parameters stand in the input's order.
  Parameters guess{};
  const auto& b = place.point.at;
  for (int i = 0; i < 3; ++i) {
    const auto turned = static_cast<std::size_t>(on->turned[place.triangle] && i > 0 ? 3 - i : i);
    const Parameters& q = corners[turned];
    guess[0] += b[i] * q[0];
    guess[1] += b[i] * q[1];
  }
  return {faces[0], model.closest_on_face(faces[0], p, guess)};
}

Surface::OnSurface Surface::Impl::project_to_model(PatchId patch, const Point& p, VertexKind kind,
                                                   std::uint32_t hint) const {
  const OnModelFace q = closest_on_faces(patch, p, kind, hint);
  Vec normal = q.at.normal;
  if (normal == Vec{})
    normal = lent_normal(hint < topology.triangles.size() ? hint : patch_triangle[patch.value]);
  return {q.at.x, normal, hint};
}

// ---- curves on edges of the model

/// The edge of the chain that is closest, going from the hint.
std::uint32_t Surface::Impl::walk_chain(CurveId curve, const Point& p, VertexKind kind,
                                        std::uint32_t hint) const {
  const std::uint32_t begin = topology.chain_begin[curve.value], end = topology.chain_begin[curve.value + 1];
  const bool closed = topology.closed(curve);
  std::uint32_t place = start_place(curve, p, kind, hint);
  double distance2 = edge_distance2(topology.chain_features[place], p);
  for (const bool forward : {true, false})
    for (std::uint32_t step = begin; step < end; ++step) {
      std::uint32_t next = forward ? place + 1 : place - 1;
      if (forward && place + 1 == end) next = closed ? begin : kNone;
      if (!forward && place == begin) next = closed ? end - 1 : kNone;
      if (next == kNone) break;
      const double d2 = edge_distance2(topology.chain_features[next], p);
      if (!(d2 < distance2)) break;
      place = next;
      distance2 = d2;
    }
  return topology.chain_features[place];
}

OnEdge Surface::Impl::closest_on_model_edge(CurveId curve, const Point& p, VertexKind kind,
                                            std::uint32_t& hint) const {
  const std::uint32_t e = on->curve_edge[curve.value];
  if (on->model().edge_has_formula(e)) {
    const bool on_curve = kind == VertexKind::ridge && hint < topology.features.size() &&
                          topology.features[hint].curve == curve;
    if (!on_curve) hint = topology.chain(curve).front();
    return on->model().closest_on_edge(e, p);
  }
  hint = walk_chain(curve, p, kind, hint);
  const auto& v = topology.features[hint].vertices;
  const Vec d = points[v[1]] - points[v[0]];
  const double length2 = norm2(d);
  const double s = length2 > 0 ? std::clamp(dot(p - points[v[0]], d) / length2, 0.0, 1.0) : 0;
  const auto [t0, t1] = on->feature_t[hint];
  return on->model().closest_on_edge(e, p, t0 + s * (t1 - t0));
}

Surface::OnCurve Surface::Impl::project_to_model_edge(CurveId curve, const Point& p, VertexKind kind,
                                                      std::uint32_t hint) const {
  const OnEdge q = closest_on_model_edge(curve, p, kind, hint);
  Vec tangent = q.tangent;
  if (tangent == Vec{}) {
    const auto& v = topology.features[hint].vertices;
    tangent = normalized(points[v[1]] - points[v[0]]);
  }
  return {q.x, tangent, hint};
}

/// A curve without an edge amid a face: along the chords, and upon the face.
Surface::OnCurve Surface::Impl::project_to_curve_in_face(CurveId curve, const Point& p, VertexKind kind,
                                                         std::uint32_t hint) const {
  hint = walk_chain(curve, p, kind, hint);
  const auto& v = topology.features[hint].vertices;
  std::uint32_t start = patch_triangle[on->curve_patch[curve.value]];
  const OnSurface q = project_to_model(PatchId(on->curve_patch[curve.value]), p, VertexKind::interior, start);
  const Vec chord = points[v[1]] - points[v[0]];
  return {q.x, normalized(chord - dot(chord, q.normal) * q.normal), hint};
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
Surface::Surface(const MeshData& mesh, const Options& options, ModelClassification classification)
    : impl_(classification.model ? std::make_unique<Impl>(mesh, options, std::move(classification))
                                 : std::make_unique<Impl>(mesh, options)) {}
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
  if (impl_->shape.patches[patch.value].planar) return impl_->project_to_plane(patch, p, kind, hint);
  return impl_->is_on_model(patch) ? impl_->project_to_model(patch, p, kind, hint)
                                   : impl_->project_to_curved(patch, p, kind, hint);
}

const Model* Surface::model() const { return impl_->on ? &impl_->on->model() : nullptr; }

std::span<const std::uint32_t> Surface::faces(PatchId patch) const {
  if (!impl_->on) return {};
  return impl_->on->patch_faces[patch.value];
}

std::uint32_t Surface::edge(CurveId curve) const {
  return impl_->on ? impl_->on->curve_edge[curve.value] : kNoEntity;
}

std::uint32_t Surface::node(std::uint32_t corner_hint) const {
  if (!impl_->on) return kNoEntity;
  const auto& nodes = impl_->on->classification.nodes;
  const auto at = std::lower_bound(nodes.begin(), nodes.end(), std::pair{corner_hint, 0u});
  return at != nodes.end() && at->first == corner_hint ? at->second : kNoEntity;
}

Surface::OnModelFace Surface::closest_on_model(PatchId patch, const Point& p, VertexKind kind,
                                               std::uint32_t hint) const {
  return impl_->closest_on_faces(patch, p, kind, hint);
}

OnEdge Surface::closest_on_model(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const {
  return impl_->closest_on_model_edge(curve, p, kind, hint);
}

Surface::OnCurve Surface::project_to_curve(CurveId curve, const Point& p, VertexKind kind,
                                           std::uint32_t hint) const {
  const SurfaceTopology& topology = impl_->topology;
  if (topology.curves[curve.value].straight) return impl_->project_to_line(curve, p, kind, hint);
  if (impl_->on) {
    if (impl_->on->curve_edge[curve.value] != kNoEntity)
      return impl_->project_to_model_edge(curve, p, kind, hint);
    if (impl_->on->curve_patch[curve.value] != kNone)
      return impl_->project_to_curve_in_face(curve, p, kind, hint);
  }
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
