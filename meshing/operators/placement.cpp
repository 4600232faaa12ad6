// The allowed space of a vertex and the bookkeeping of a move.
#include "meshing/operators/placement.h"

#include "meshing/operators/check_cavity.h"
#include "meshing/operators/surface_fit.h"

namespace weft::meshing {
namespace {

/// A face of curved boundary as it is once a vertex has moved, and what the reference surface is near it.
struct MovedTriangle {
  TetId tet;
  int face;
  PatchId patch;
  std::array<Point, 3> points;
  Vec normal;       // of the surface
  double distance;  // of the centroid from the surface
};

/// A face that moves may not turn away from the surface, as the mesh would overlap itself: on the side where
/// it was it stays.
bool turns(const Worker& w, const MovedTriangle& moved) {
  const auto at = [&](int i) { return w.mesh.point(w.mesh.vertex(moved.tet, kTetFaces[moved.face][i])); };
  const Vec old = cross(at(1) - at(0), at(2) - at(0));
  const Vec now = cross(moved.points[1] - moved.points[0], moved.points[2] - moved.points[0]);
  const double before = dot(old, moved.normal), after = dot(now, moved.normal);
  return before > 0 ? after < 0.2 * norm(now) && after * norm(old) < before * norm(now)
                    : after > -0.2 * norm(now) && after * norm(old) > before * norm(now);
}

/// Whether `accept` takes each face of curved boundary around v when v is at x.
template <typename Accept>
bool each_moved_triangle(const Worker& w, VertexId v, const Point& x, Accept accept) {
  const TetMesh& mesh = w.mesh;
  for (const auto& [t, local] : w.ball.tets)
    for (int f = 0; f < 4; ++f) {
      const PatchId patch = f == local ? PatchId() : mesh.patch(t, f);
      if (!patch.valid() || w.kernel.surface.patches()[patch.value].planar) continue;
      MovedTriangle moved{t, f, patch, {}, {}, 0};
      VertexId near = v;
      for (int i = 0; i < 3; ++i) {
        const VertexId u = mesh.vertex(t, kTetFaces[f][i]);
        moved.points[i] = u == v ? x : mesh.point(u);
        if (u != v) near = u;
      }
      const Point centroid = (1.0 / 3) * (moved.points[0] + moved.points[1] + moved.points[2]);
      const auto q =
          w.kernel.surface.project_to_patch(patch, centroid, mesh.kind(near), mesh.surface_hint(near));
      moved.normal = q.normal;
      moved.distance = norm(centroid - q.x);
      if (!accept(moved)) return false;
    }
  return true;
}

/// The boundary faces around the moved vertex stay near the reference surface, at their centroids; one that
/// is too far from it already comes no farther away.
bool stays_on_surface(const Worker& w, VertexId v, const Point& x) {
  const Surface& surface = w.kernel.surface;
  return each_moved_triangle(w, v, x, [&](const MovedTriangle& moved) {
    const bool far = moved.distance > w.kernel.hausd(moved.patch);
    if (far && moved.distance > surface_deviation(w.mesh, surface, moved.patch, moved.tet, moved.face))
      return false;
    return !turns(w, moved);
  });
}

}  // namespace

Verdict move_space(const Worker& w, VertexId v, MoveSpace& space) {
  const TetMesh& mesh = w.mesh;
  space.kind = mesh.kind(v);
  if (mesh.fixed(v) || space.kind == VertexKind::corner) return Verdict::required;
  if (space.kind == VertexKind::interior) return Verdict::accepted;
  const Surface& s = w.kernel.surface;
  if (space.kind == VertexKind::surface) {
    for (const auto& [t, local] : w.ball.tets)
      for (int f = 0; f < 4 && !space.patch.valid(); ++f)
        if (f != local) space.patch = mesh.patch(t, f);
    if (!space.patch.valid()) return Verdict::breaks_classification;
    space.curved = !s.patches()[space.patch.value].planar;
    space.direction =
        space.curved ? s.project_to_patch(space.patch, mesh.point(v), space.kind, mesh.surface_hint(v)).normal
                     : s.patches()[space.patch.value].normal;
    return Verdict::accepted;
  }
  for (const auto& [t, local] : w.ball.tets)
    for (int i = 0; i < 4 && !space.curve.valid(); ++i)
      if (i != local) space.curve = mesh.curve(v, mesh.vertex(t, i));
  if (!space.curve.valid()) return Verdict::breaks_classification;
  if (s.curves()[space.curve.value].required) return Verdict::required;
  space.curved = true;  // patches beside a straight curve may be curved; move_to looks
  space.direction = s.project_to_curve(space.curve, mesh.point(v), space.kind, mesh.surface_hint(v)).tangent;
  return Verdict::accepted;
}

bool move_to(Worker& w, VertexId v, const MoveSpace& space, const Point& target, MovedVertex& moved) {
  const TetMesh& mesh = w.mesh;
  const Surface& s = w.kernel.surface;
  moved.x = target;
  moved.surface_hint = mesh.surface_hint(v);
  if (space.kind == VertexKind::surface && space.curved) {
    const auto q = s.project_to_patch(space.patch, target, space.kind, moved.surface_hint);
    moved.x = q.x;
    moved.surface_hint = q.hint;
  } else if (space.kind == VertexKind::ridge) {
    const auto q = s.project_to_curve(space.curve, target, space.kind, moved.surface_hint);
    if (!s.curves()[space.curve.value].straight) moved.x = q.x;
    moved.surface_hint = q.hint;
  }
  if (space.curved && !stays_on_surface(w, v, moved.x)) return false;
  const Background::Sample sample = w.kernel.background.at(moved.x, mesh.background_hint(v));
  moved.log_metric = sample.log_metric;
  moved.metric = exp_fast(sample.log_metric);
  moved.background_hint = sample.tet;
  return true;
}

bool turns_boundary(const Worker& w, VertexId v, const Point& x) {
  return !each_moved_triangle(w, v, x, [&](const MovedTriangle& moved) { return !turns(w, moved); });
}

void commit_move(Worker& w, const Ball& ball, const MovedVertex& moved, std::span<const float> qualities) {
  TetMesh& mesh = w.mesh;
  const VertexId v = ball.centre;
  const Limits& limits = w.kernel.limits;
  // A short step hardly changes what is best for the neighbours: only a long one calls them up again.
  const bool far = squared_length(moved.metric, moved.x - mesh.point(v)) > limits.far_step * limits.far_step;
  mesh.set_point(v, moved.x);
  mesh.set_metric(v, moved.log_metric, moved.metric);
  mesh.set_background_hint(v, moved.background_hint);
  mesh.set_surface_hint(v, moved.surface_hint);
  for (std::size_t i = 0; i < ball.tets.size(); ++i) {
    mesh.set_quality(ball.tets[i].tet, qualities[i]);
    mesh.mark(ball.tets[i].tet, kCheckSwap | kCheckPoor);
  }
  mesh.take_marks(v, kStuck);
  for (const auto& [u, first] : ball.link) {
    mesh.take_marks(u, kStuck);
    if (far) mesh.mark(u, kCheckPlace);
    const MetricLength length = edge_between(mesh, u, v);
    if (length.above(limits.long_edge)) mesh.mark(ball.tets[first].tet, kCheckLong);
    if (length.below(limits.short_edge)) {
      mesh.mark(u, kCheckShort);
      mesh.mark(v, kCheckShort);
    }
  }
  if (far) mesh.mark(v, kCheckPlace);
  check_cavity(w, v);
}

}  // namespace weft::meshing
