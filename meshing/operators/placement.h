// Where a vertex may move, and what moving it involves: geometry, metric, cached qualities, marks.
#pragma once

#include <span>

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// The space a vertex may move in: all (interior), the tangent plane of `patch` with normal `direction`, or
/// the line along `direction` of `curve`.
struct MoveSpace {
  VertexKind kind = VertexKind::interior;
  PatchId patch;
  CurveId curve;
  Vec direction;
  bool curved = false;
};

struct MovedVertex {
  Point x;
  LogMetric log_metric;
  Metric metric;
  std::uint32_t background_hint, surface_hint;
  const SymTensor& tensor(MetricMean mean) const { return judge_tensor(mean, metric, log_metric); }
};

/// Finds the space of `v`, whose ball is gathered in w.ball. Refuses corners and fixed or non-manifold
/// vertices.
Verdict move_space(const Worker& w, VertexId v, MoveSpace& space);

/// Puts `target` on the geometry and reads the metric there. False when the boundary around would leave the
/// surface.
bool move_to(Worker& w, VertexId v, const MoveSpace& space, const Point& target, MovedVertex& moved);

/// Whether a triangle of curved boundary would turn away from the surface with `v` at `x`: the mesh would
/// overlap itself though all tets are positive. The ball of v is gathered in w.ball.
bool turns_boundary(const Worker& w, VertexId v, const Point& x);

/// Moves the ball's centre; `qualities` are those of the ball's tets afterwards.
void commit_move(Worker& w, const Ball& ball, const MovedVertex& moved, std::span<const float> qualities);

}  // namespace weft::meshing
