// The reference geometry's queries: where a walk starts, the walk, and the point it ends on.
#include "meshing/geometry/surface/surface.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "meshing/geometry/surface/curved_triangle.h"
#include "meshing/geometry/surface/cut_surface.h"
#include "meshing/geometry/surface/surface_tables.h"

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
  std::uint32_t name = kNoName;
  TriangleView triangle;
  TrianglePoint point{{}, kInfinity};
};

TrianglePoint closest_flat(const TriangleView& t, const Point& p) {
  return closest_point(t.corner(0), t.corner(1), t.corner(2), p);
}

CurvedTriangle curved(const TriangleView& t) { return CurvedTriangle(t.corners(), t.handles()); }

/// Where on an edge, from its lower vertex, the point closest to p lies.
double share_along(const SurfaceFeature& f, const Point& p) {
  const Vec d = f.ends[1] - f.ends[0];
  const double length2 = norm2(d);
  return length2 > 0 ? std::clamp(dot(p - f.ends[0], d) / length2, 0.0, 1.0) : 0;
}

double edge_distance2(const SurfaceFeature& f, const Point& p) {
  return norm2(p - f.ends[0] - share_along(f, p) * (f.ends[1] - f.ends[0]));
}

/// The arc of an edge, in its curve's direction.
CubicArc arc_of(const SurfaceFeature& f) {
  const std::size_t a = f.forward ? 0 : 1, b = 1 - a;
  return {f.ends[a], f.ends[b], f.handles[a], f.handles[b]};
}

/// The closest of all things of some kind that are here, by name. `distance2(piece, thing)`.
template <class T, class Eligible, class Distance2>
std::uint32_t closest_here(const SurfacePieces& pieces, std::span<const T> SurfacePiece::*list,
                           const Point& p, const Eligible& eligible, const Distance2& distance2) {
  std::uint32_t best = kNoName;
  double best_distance2 = kInfinity;
  for (const SurfacePieces::Piece& piece : pieces.all()) {
    const std::span<const T> all = (*piece).*list;
    if (all.empty() || piece->box.distance2(p) >= best_distance2) continue;
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      if (!eligible(all[i])) continue;
      if (const double d2 = distance2(*piece, all[i]); d2 < best_distance2)
        best = surface_name(piece->id, i), best_distance2 = d2;
    }
  }
  return best;
}

}  // namespace

struct Surface::Impl {
  explicit Impl(BuiltSurface&& built)
      : tables(std::move(built.tables)), input(std::move(built.input)), cutter(std::move(built.cutter)) {}

  std::shared_ptr<const SurfaceTables> tables;
  SurfacePieces pieces;
  SurfaceInput input;
  std::shared_ptr<const SurfaceCutter> cutter;  // until there are pieces

  OnModelFace closest_on_faces(PatchId patch, const Point& p, VertexKind kind, std::uint32_t& hint) const;
  OnSurface project_to_model(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  OnEdge closest_on_model_edge(CurveId curve, const Point& p, VertexKind kind, std::uint32_t& hint) const;
  OnCurve project_to_model_edge(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  OnCurve project_to_curve_in_face(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  std::uint32_t walk_chain(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;

  OnSurface project_to_plane(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  OnSurface project_to_curved(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  bool in_patch(PatchId patch, VertexKind kind, std::uint32_t hint) const;
  bool on_curve(CurveId curve, VertexKind kind, std::uint32_t hint) const;
  Place place_at(std::uint32_t name) const { return {name, pieces.triangle(name)}; }
  Place start(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  template <class Closest>
  Place descend(Place place, double margin, const Closest& closest) const;
  template <class Closest>
  Place closest_across(const Place& place, int edge, const Closest& closest) const;
  template <class Closest>
  Place best_around(const Place& place, int corner, const Closest& closest) const;

  OnCurve project_to_line(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  OnCurve project_to_arcs(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
  std::uint32_t start_feature(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;
};

// ---- patches

/// Whether the hint is a triangle of the patch.
bool Surface::Impl::in_patch(PatchId patch, VertexKind kind, std::uint32_t hint) const {
  if (kind != VertexKind::surface) return false;
  const TriangleView t = pieces.triangle(hint);
  return t && t.patch() == patch;
}

Surface::OnSurface Surface::Impl::project_to_plane(PatchId patch, const Point& p, VertexKind kind,
                                                   std::uint32_t hint) const {
  const Plane& plane = tables->planes[patch.value];
  OnSurface result{p, plane.normal, in_patch(patch, kind, hint) ? hint : kNoName};
  const double height = dot(plane.normal, p - plane.point);
  if (std::abs(height) <= plane.rounding) return result;
  result.x = p - height * plane.normal;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(plane.normal[i]) == 1) result.x[i] = plane.point[i];
  }
  return result;
}

/// Where a walk in a patch starts; no triangle where none of the patch is here.
Place Surface::Impl::start(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const {
  if (kind == VertexKind::surface)
    if (const Place at = place_at(hint); at.triangle && at.triangle.patch() == patch) return at;
  Place best;
  const auto offer = [&](std::span<const std::uint32_t> names) {
    for (const std::uint32_t name : names) {
      const TriangleView t = pieces.triangle(name);
      if (!t || t.patch() != patch) continue;
      if (const double d2 = closest_flat(t, p).distance2; d2 < best.point.distance2) {
        best = {name, t};
        best.point.distance2 = d2;
      }
    }
  };
  if (kind == VertexKind::ridge) {
    if (const SurfaceFeature* f = pieces.feature(hint)) offer(pieces.piece_of(hint)->triangles_at(*f));
  } else if (kind == VertexKind::corner) {
    if (const SurfaceCorner* c = pieces.corner(hint)) offer(pieces.piece_of(hint)->triangles_at(*c));
  }
  if (best.triangle) return best;
  return place_at(closest_here(
      pieces, &SurfacePiece::triangles, p, [&](const SurfaceTriangle& t) { return t.patch == patch; },
      [&](const SurfacePiece& piece, const SurfaceTriangle& t) {
        return closest_flat({piece, t}, p).distance2;
      }));
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
  Place n = place_at(place.triangle.neighbours()[edge]);
  if (!n.triangle) return {};
  const auto v = place.triangle.vertices(), w = n.triangle.vertices();
  const int j = (edge + 1) % 3, k = (edge + 2) % 3;
  const double share = place.point.at[k] / (place.point.at[j] + place.point.at[k]);
  Barycentric start{};
  start[corner_of(w, v[j])] = 1 - share;
  start[corner_of(w, v[k])] = share;
  n.point = closest(n.triangle, start);
  return n;
}

/// The closest place in the other triangles of the fan around a corner.
template <class Closest>
Place Surface::Impl::best_around(const Place& place, int corner, const Closest& closest) const {
  const std::uint32_t vertex = place.triangle.vertices()[corner];
  Place best;
  for (int side : {1, 2}) {
    TriangleView t = place.triangle;
    int i = corner;
    bool closed = false;
    for (;;) {
      Place n = place_at(t.neighbours()[(i + side) % 3]);
      closed = n.name == place.name;
      if (!n.triangle || closed) break;
      t = n.triangle;
      i = corner_of(t.vertices(), vertex);
      Barycentric start{};
      start[i] = 1;
      n.point = closest(t, start);
      if (n.point.distance2 < best.point.distance2) best = n;
    }
    if (closed) break;  // one way around has seen them all
  }
  return best;
}

Surface::OnSurface Surface::Impl::project_to_curved(PatchId patch, const Point& p, VertexKind kind,
                                                    std::uint32_t hint) const {
  const auto flat = [&](const TriangleView& t, const Barycentric&) { return closest_flat(t, p); };
  const auto bent = [&](const TriangleView& t, const Barycentric& start) {
    return curved(t).closest(p, start);
  };
  Place place = start(patch, p, kind, hint);
  if (!place.triangle) return {p, {}, kNoName};
  place.point = closest_flat(place.triangle, p);
  place = descend(place, 0, flat);
  place.point = bent(place.triangle, place.point.at);
  place = descend(place, kKinkMargin, bent);
  const auto [x, normal] = curved(place.triangle).frame(place.point.at);
  return {x, normal == Vec{} ? place.triangle.lent_normal() : normal, place.name};
}

// ---- patches on faces of the model

/// `hint` becomes that of the next query.
Surface::OnModelFace Surface::Impl::closest_on_faces(PatchId patch, const Point& p, VertexKind kind,
                                                     std::uint32_t& hint) const {
  const Model& model = *tables->model;
  const std::vector<std::uint32_t>& faces = tables->patch_faces[patch.value];
  if (faces.size() == 1 && model.has_formula(faces[0])) {
    if (!in_patch(patch, kind, hint)) hint = kNoName;
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
  const auto flat = [&](const TriangleView& t, const Barycentric&) { return closest_flat(t, p); };
  Place place = start(patch, p, kind, hint);
  hint = place.name;
  if (!place.triangle) return {faces[0], model.closest_on_face(faces[0], p)};
  place.point = closest_flat(place.triangle, p);
  place = descend(place, 0, flat);
  hint = place.name;
  const auto& corners = pieces.piece_of(place.name)->parameters[place_of_name(place.name)];
  Parameters guess{};
  const auto& b = place.point.at;
  for (int i = 0; i < 3; ++i) {
    guess[0] += b[i] * corners[i][0];
    guess[1] += b[i] * corners[i][1];
  }
  return {faces[0], model.closest_on_face(faces[0], p, guess)};
}

Surface::OnSurface Surface::Impl::project_to_model(PatchId patch, const Point& p, VertexKind kind,
                                                   std::uint32_t hint) const {
  const std::uint32_t from = hint;
  const OnModelFace q = closest_on_faces(patch, p, kind, hint);
  Vec normal = q.at.normal;
  if (normal == Vec{}) {
    TriangleView near = pieces.triangle(hint);
    if (!near) near = start(patch, p, kind, from).triangle;
    normal = near ? near.lent_normal() : Vec{0, 0, 1};
  }
  return {q.at.x, normal, hint};
}

// ---- curves on edges of the model

/// The edge of the curve that is closest, going from the hint; kNoName where none is here.
std::uint32_t Surface::Impl::walk_chain(CurveId curve, const Point& p, VertexKind kind,
                                        std::uint32_t hint) const {
  std::uint32_t place = start_feature(curve, p, kind, hint);
  const SurfaceFeature* at = pieces.feature(place);
  if (!at) return kNoName;
  double distance2 = edge_distance2(*at, p);
  for (const auto next_of : {&SurfaceFeature::next, &SurfaceFeature::previous})
    for (int step = 0; step < kMaxSteps; ++step) {
      const std::uint32_t next = at->*next_of;
      const SurfaceFeature* f = pieces.feature(next);
      if (!f) break;
      const double d2 = edge_distance2(*f, p);
      if (!(d2 < distance2)) break;
      place = next;
      at = f;
      distance2 = d2;
    }
  return place;
}

OnEdge Surface::Impl::closest_on_model_edge(CurveId curve, const Point& p, VertexKind kind,
                                            std::uint32_t& hint) const {
  const std::uint32_t e = tables->curve_edge[curve.value];
  if (tables->model->edge_has_formula(e)) {
    if (!on_curve(curve, kind, hint)) hint = start_feature(curve, p, kind, hint);
    return tables->model->closest_on_edge(e, p);
  }
  hint = walk_chain(curve, p, kind, hint);
  const SurfaceFeature* f = pieces.feature(hint);
  if (!f) return tables->model->closest_on_edge(e, p);
  return tables->model->closest_on_edge(e, p, f->t[0] + share_along(*f, p) * (f->t[1] - f->t[0]));
}

Surface::OnCurve Surface::Impl::project_to_model_edge(CurveId curve, const Point& p, VertexKind kind,
                                                      std::uint32_t hint) const {
  const OnEdge q = closest_on_model_edge(curve, p, kind, hint);
  Vec tangent = q.tangent;
  if (const SurfaceFeature* f = pieces.feature(hint); f && tangent == Vec{})
    tangent = normalized(f->ends[1] - f->ends[0]);
  return {q.x, tangent, hint};
}

/// A curve without an edge amid a face: along the chords, and upon the face.
Surface::OnCurve Surface::Impl::project_to_curve_in_face(CurveId curve, const Point& p, VertexKind kind,
                                                         std::uint32_t hint) const {
  hint = walk_chain(curve, p, kind, hint);
  const SurfaceFeature* f = pieces.feature(hint);
  if (!f) return {p, {}, kNoName};
  const OnSurface q = project_to_model(PatchId(tables->curve_patch[curve.value]), p, VertexKind::ridge, hint);
  const Vec chord = f->ends[1] - f->ends[0];
  return {q.x, normalized(chord - dot(chord, q.normal) * q.normal), hint};
}

// ---- curves

/// Whether the hint is an edge of the curve.
bool Surface::Impl::on_curve(CurveId curve, VertexKind kind, std::uint32_t hint) const {
  if (kind != VertexKind::ridge) return false;
  const SurfaceFeature* f = pieces.feature(hint);
  return f && f->curve == curve;
}

/// kNoName where no edge of the curve is here.
std::uint32_t Surface::Impl::start_feature(CurveId curve, const Point& p, VertexKind kind,
                                           std::uint32_t hint) const {
  if (on_curve(curve, kind, hint)) return hint;
  std::uint32_t best = kNoName;
  double best_distance2 = kInfinity;
  const SurfaceCorner* corner = kind == VertexKind::corner ? pieces.corner(hint) : nullptr;
  if (corner)
    for (const std::uint32_t name : pieces.piece_of(hint)->features_at(*corner)) {
      const SurfaceFeature* f = pieces.feature(name);
      if (!f || f->curve != curve) continue;
      if (const double d2 = edge_distance2(*f, p); d2 < best_distance2) best = name, best_distance2 = d2;
    }
  if (best != kNoName || !tables->curve_in_pieces[curve.value]) return best;
  return closest_here(
      pieces, &SurfacePiece::features, p, [&](const SurfaceFeature& f) { return f.curve == curve; },
      [&](const SurfacePiece&, const SurfaceFeature& f) { return edge_distance2(f, p); });
}

Surface::OnCurve Surface::Impl::project_to_line(CurveId curve, const Point& p, VertexKind kind,
                                                std::uint32_t hint) const {
  const Line& line = tables->lines[curve.value];
  const Point on_line = line.point + dot(p - line.point, line.direction) * line.direction;
  OnCurve result{norm(on_line - p) <= line.rounding ? p : on_line, line.direction};
  // Go to the edge that holds the point, for the hint.
  result.hint = start_feature(curve, p, kind, hint);
  const SurfaceFeature* at = pieces.feature(result.hint);
  const auto beyond = [&](const Point& end) { return dot(p - end, line.direction); };
  const auto go = [&](std::uint32_t name) {
    const SurfaceFeature* next = pieces.feature(name);
    if (next) at = next, result.hint = name;
    return next != nullptr;
  };
  while (at && beyond(at->ends[at->forward ? 1 : 0]) > 0 && go(at->next)) {
  }
  while (at && beyond(at->ends[at->forward ? 0 : 1]) < 0 && go(at->previous)) {
  }
  return result;
}

Surface::OnCurve Surface::Impl::project_to_arcs(CurveId curve, const Point& p, VertexKind kind,
                                                std::uint32_t hint) const {
  std::uint32_t place = start_feature(curve, p, kind, hint);
  const SurfaceFeature* at = pieces.feature(place);
  if (!at) return {p, {}, kNoName};
  ArcPoint best = closest_point(arc_of(*at), p, 0.5);
  // Along the chain as long as the next arc is closer.
  for (int step = 0; step < kMaxSteps && (best.s == 0 || best.s == 1); ++step) {
    const bool forward = best.s == 1;
    const std::uint32_t next = forward ? at->next : at->previous;
    const SurfaceFeature* f = pieces.feature(next);
    if (!f) break;
    const ArcPoint candidate = closest_point(arc_of(*f), p, forward ? 0 : 1);
    if (!(candidate.distance2 < best.distance2)) break;
    best = candidate;
    place = next;
    at = f;
  }
  return {best.x, best.tangent, place};
}

// ---- the public face

Surface::Surface(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Surface::Surface(const MeshData& mesh, const Options& options) : Surface(mesh, options, {}) {}
Surface::Surface(const MeshData& mesh, const Options& options, ModelClassification classification)
    : impl_(std::make_unique<Impl>(build_surface(mesh, options, std::move(classification)))) {
  const std::shared_ptr<const SurfaceCutter> cutter = std::exchange(impl_->cutter, nullptr);
  std::vector<SurfacePieces::Piece> all;
  for (const std::uint32_t id : cutter->ids()) all.push_back(cutter->piece(id));
  impl_->pieces.add(all);
}
Surface::Surface(std::shared_ptr<const SurfaceTables> tables)
    : impl_(std::make_unique<Impl>(BuiltSurface{std::move(tables), {}, {}})) {}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

Surface Surface::part(SurfacePieces pieces) const {
  auto impl = std::make_unique<Impl>(BuiltSurface{impl_->tables, {}, {}});
  impl->pieces = std::move(pieces);
  return Surface(std::move(impl));
}
const SurfacePieces& Surface::pieces() const { return impl_->pieces; }

std::span<const Patch> Surface::patches() const { return impl_->tables->patches; }
std::span<const Curve> Surface::curves() const { return impl_->tables->curves; }
std::span<const Surface::FeatureEdge> Surface::feature_edges() const { return impl_->input.features; }
PatchId Surface::triangle_patch(std::uint32_t triangle) const {
  return impl_->input.triangle_patch[triangle];
}
VertexKind Surface::vertex_kind(std::uint32_t vertex) const { return impl_->input.vertex_kind[vertex]; }
std::uint32_t Surface::vertex_hint(std::uint32_t vertex) const { return impl_->input.vertex_hint[vertex]; }

Surface::OnSurface Surface::project_to_patch(PatchId patch, const Point& p, VertexKind kind,
                                             std::uint32_t hint) const {
  if (impl_->tables->patches[patch.value].planar) return impl_->project_to_plane(patch, p, kind, hint);
  return impl_->tables->is_on_model(patch) ? impl_->project_to_model(patch, p, kind, hint)
                                           : impl_->project_to_curved(patch, p, kind, hint);
}

Surface::OnCurve Surface::project_to_curve(CurveId curve, const Point& p, VertexKind kind,
                                           std::uint32_t hint) const {
  const SurfaceTables& tables = *impl_->tables;
  if (tables.curves[curve.value].straight) return impl_->project_to_line(curve, p, kind, hint);
  if (tables.model) {
    if (tables.curve_edge[curve.value] != kNoEntity)
      return impl_->project_to_model_edge(curve, p, kind, hint);
    if (tables.curve_patch[curve.value] != kNone)
      return impl_->project_to_curve_in_face(curve, p, kind, hint);
  }
  return impl_->project_to_arcs(curve, p, kind, hint);
}

const Model* Surface::model() const { return impl_->tables->model.get(); }

std::span<const std::uint32_t> Surface::faces(PatchId patch) const {
  if (!model()) return {};
  return impl_->tables->patch_faces[patch.value];
}

std::uint32_t Surface::edge(CurveId curve) const {
  return model() ? impl_->tables->curve_edge[curve.value] : kNoEntity;
}

std::uint32_t Surface::node(std::uint32_t corner_hint) const {
  const SurfaceCorner* corner = impl_->pieces.corner(corner_hint);
  return corner ? corner->node : kNoEntity;
}

Surface::OnModelFace Surface::closest_on_model(PatchId patch, const Point& p, VertexKind kind,
                                               std::uint32_t hint) const {
  return impl_->closest_on_faces(patch, p, kind, hint);
}

OnEdge Surface::closest_on_model(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const {
  return impl_->closest_on_model_edge(curve, p, kind, hint);
}

}  // namespace weft::meshing
