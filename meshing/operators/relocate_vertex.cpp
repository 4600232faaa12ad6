// Relocation of a vertex whose ball smoothing cannot repair.
#include "meshing/operators/relocate_vertex.h"

#include <algorithm>

#include "meshing/operators/best_place.h"
#include "meshing/operators/placement.h"

namespace weft::meshing {

Verdict relocate_vertex(Worker& w, VertexId v) {
  TetMesh& mesh = w.mesh;
  if (mesh.frozen(v)) return Verdict::frozen;
  if (const Verdict r = gather_ball(mesh, w.claims, v, w.ball); r != Verdict::accepted) return r;
  if (mesh.kind(v) != VertexKind::interior || mesh.fixed(v)) return Verdict::not_needed;
  if (w.ball.tets.size() > kMostFaces) return Verdict::too_large;
  w.faces.gather(w.mean(), mesh, w.ball);
  double old_worst = 1;
  for (const auto& [t, local] : w.ball.tets) old_worst = std::min<double>(old_worst, mesh.quality(t));
  const auto place = best_place(w.faces, mesh.point(v), mesh.metric(v), judge_tensor(w.mean(), mesh, v));
  if (!place) return Verdict::not_needed;
  MovedVertex moved;
  if (!move_to(w, v, MoveSpace{}, *place, moved)) return Verdict::leaves_surface;
  const double worst = w.faces.qualities(moved.x, moved.tensor(w.mean()), w.qualities);
  if (worst < 0) return Verdict::inverts;
  if (worst < old_worst + std::max(1e-3, 0.02 * old_worst)) return Verdict::worsens_quality;
  commit_move(w, w.ball, moved, w.qualities);
  return Verdict::accepted;
}

}  // namespace weft::meshing
