// The place on the model, and as much of the way there as keeps all tets positive.
#include "meshing/operators/snap_vertex.h"

#include <algorithm>
#include <optional>

#include "meshing/operators/placement.h"

namespace weft::meshing {
namespace {

// Of the model's size: what is nearer is on it, but for rounding.
constexpr double kRounding = 1e-14;

/// Whether an edge at the centre of the gathered ball must stay as it is; those of required triangles must.
bool has_required_edge(const Worker& w, VertexId v) {
  const auto is_required = [&](VertexId u) {
    const CurveId c = u == v ? CurveId() : w.mesh.curve(v, u);
    return c.valid() && w.kernel.surface.curves()[c.value].required;
  };
  return std::ranges::any_of(w.ball.tets, [&](const Ball::Entry& e) {
    return std::ranges::any_of(w.mesh.vertices(e.tet), is_required);
  });
}

/// Empty where nothing of the model is known to be there.
std::optional<Point> place_on_model(const Worker& w, VertexId v) {
  const TetMesh& mesh = w.mesh;
  const Surface& s = w.kernel.surface;
  if (mesh.kind(v) == VertexKind::corner) {
    const std::uint32_t node = s.node(mesh.surface_hint(v));
    if (node == kNoEntity || has_required_edge(w, v)) return std::nullopt;
    return s.model()->node(node);
  }
  MoveSpace space;
  if (move_space(w, v, space) != Verdict::accepted || space.kind == VertexKind::interior) return std::nullopt;
  if (space.kind == VertexKind::ridge) {
    if (s.edge(space.curve) == kNoEntity) return std::nullopt;
    return s.project_to_curve(space.curve, mesh.point(v), space.kind, mesh.surface_hint(v)).x;
  }
  if (s.faces(space.patch).empty()) return std::nullopt;
  return s.project_to_patch(space.patch, mesh.point(v), space.kind, mesh.surface_hint(v)).x;
}

/// On the reference surface, whatever that is.
std::optional<Point> place_on_surface(const Worker& w, VertexId v) {
  const Surface& s = w.kernel.surface;
  MoveSpace space;
  if (move_space(w, v, space) != Verdict::accepted || space.kind == VertexKind::interior) return std::nullopt;
  if (space.kind == VertexKind::ridge)
    return s.project_to_curve(space.curve, w.mesh.point(v), space.kind, w.mesh.surface_hint(v)).x;
  return s.project_to_patch(space.patch, w.mesh.point(v), space.kind, w.mesh.surface_hint(v)).x;
}

MovedVertex moved_to(const Worker& w, VertexId v, const Point& x) {
  const Background::Sample sample = w.kernel.background.at(x, w.mesh.background_hint(v));
  return {x, sample.log_metric, exp_fast(sample.log_metric), sample.tet, w.mesh.surface_hint(v)};
}

Verdict move_towards(Worker& w, VertexId v, const Point& target) {
  const Point from = w.mesh.point(v);
  const Vec way = target - from;
  w.faces.gather(w.mean(), w.mesh, w.ball);
  for (double share = 1; share > 0.1; share *= 0.5) {
    const MovedVertex moved = moved_to(w, v, share == 1 ? target : from + share * way);
    if (w.faces.qualities(moved.x, moved.tensor(w.mean()), w.qualities) <= 0) continue;
    if (turns_boundary(w, v, moved.x)) continue;
    commit_move(w, w.ball, moved, w.qualities);
    return share == 1 ? Verdict::accepted : Verdict::inverts;
  }
  return Verdict::inverts;
}

}  // namespace

Verdict snap_vertex(Worker& w, VertexId v) {
  TetMesh& mesh = w.mesh;
  if (mesh.frozen(v)) return Verdict::frozen;
  if (mesh.flags(v) & kListedRequired) return Verdict::required;
  if (const Verdict r = gather_ball(mesh, w.claims, v, w.ball); r != Verdict::accepted) return r;
  const std::optional<Point> target = place_on_model(w, v);
  if (!target) return Verdict::not_needed;
  if (norm(*target - mesh.point(v)) <= kRounding * w.kernel.surface.model()->size())
    return Verdict::not_needed;
  return move_towards(w, v, *target);
}

Verdict raise_vertex(Worker& w, VertexId v) {
  if (const Verdict r = gather_ball(w.mesh, w.claims, v, w.ball); r != Verdict::accepted) return r;
  const std::optional<Point> target = place_on_surface(w, v);
  return target ? move_towards(w, v, *target) : Verdict::not_needed;
}

}  // namespace weft::meshing
