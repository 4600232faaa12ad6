// Newton smoothing of interior, surface and ridge vertices.
#include "meshing/operators/smooth_vertex.h"

#include <algorithm>

#include "meshing/kernel/ball_objective.h"
#include "meshing/operators/placement.h"

namespace weft::meshing {
namespace {

/// Solves H x = -g for symmetric H by L D L^T, whose error grows with the condition number; that of an
/// inverse by cofactors grows with its square. False when H is not safely positive definite.
bool newton_step(const SymTensor& h, const Vec& g, Vec& step) {
  constexpr double kRounding = 1e-15;  // a pivot that has cancelled further is noise
  if (!(h.xx > 0)) return false;
  const double yx = h.xy / h.xx, zx = h.xz / h.xx;
  const double dy = h.yy - yx * h.xy, yz = h.yz - yx * h.xz;
  if (!(dy > kRounding * h.yy)) return false;
  const double zy = yz / dy, dz = h.zz - zx * h.xz - zy * yz;
  if (!(dz > kRounding * h.zz)) return false;
  const double y = -g.y + yx * g.x, z = -g.z + zx * g.x - zy * y;
  step.z = z / dz;
  step.y = y / dy - zy * step.z;
  step.x = -g.x / h.xx - yx * step.y - zx * step.z;
  return true;
}

/// Newton step within the plane of normal n (2 x 2 in an orthonormal basis that keeps coordinate planes
/// exact).
bool newton_step_in_plane(const SymTensor& h, const Vec& g, const Vec& n, Vec& step) {
  const Vec a = std::abs(n.x) < std::abs(n.y) ? (std::abs(n.x) < std::abs(n.z) ? Vec{1, 0, 0} : Vec{0, 0, 1})
                                              : (std::abs(n.y) < std::abs(n.z) ? Vec{0, 1, 0} : Vec{0, 0, 1});
  Vec u = cross(n, a);
  u = (1 / norm(u)) * u;
  const Vec v = cross(n, u);
  const double huu = squared_length(h, u), hvv = squared_length(h, v), huv = dot(u, apply(h, v));
  const double d = huu * hvv - huv * huv;
  if (!(huu > 0 && d > 1e-15 * huu * hvv)) return false;
  const double gu = dot(g, u), gv = dot(g, v);
  step = ((-gu * hvv + gv * huv) / d) * u + ((-gv * huu + gu * huv) / d) * v;
  return true;
}

double sum_of_inverses(const std::vector<float>& qualities) {
  double sum = 0;
  for (const float q : qualities) sum += 1.0 / q;
  return sum;
}

}  // namespace

Verdict smooth_vertex(Worker& w, VertexId v) {
  if (w.mesh.frozen(v)) return Verdict::frozen;
  if (const Verdict r = gather_ball(w.mesh, w.claims, v, w.ball); r != Verdict::accepted) return r;
  return smooth_gathered(w);
}

Verdict smooth_gathered(Worker& w) {
  TetMesh& mesh = w.mesh;
  const VertexId v = w.ball.centre;
  MoveSpace space;
  if (const Verdict r = move_space(w, v, space); r != Verdict::accepted) return r;
  w.faces.gather(w.mean(), mesh, w.ball);
  const Point old = mesh.point(v);
  const BallDerivatives d = w.faces.derivatives(old, judge_tensor(w.mean(), mesh, v));
  Vec step;
  if (space.kind == VertexKind::interior) {
    if (!newton_step(d.hessian, d.gradient, step)) return Verdict::not_needed;
  } else if (space.kind == VertexKind::surface) {
    if (!newton_step_in_plane(d.hessian, d.gradient, space.direction, step)) return Verdict::not_needed;
  } else {
    const double h = squared_length(d.hessian, space.direction);
    if (!(h > 0)) return Verdict::not_needed;
    step = (-dot(d.gradient, space.direction) / h) * space.direction;
  }
  // Steps far below the local size change nothing worth the work that they would cause around.
  const double shortest = w.kernel.limits.shortest_step;
  if (!(squared_length(mesh.metric(v), step) >= shortest * shortest)) return Verdict::not_needed;
  double old_worst = 1, old_sum = 0;
  for (const auto& [t, local] : w.ball.tets) {
    old_worst = std::min<double>(old_worst, mesh.quality(t));
    old_sum += 1.0 / std::max(mesh.quality(t), 1e-12f);
  }
  Verdict verdict = Verdict::not_needed;
  for (double damping = 1; damping > 0.2; damping *= 0.5) {
    MovedVertex moved;
    if (!move_to(w, v, space, old + damping * step, moved)) return Verdict::leaves_surface;
    const double worst = w.faces.qualities(moved.x, moved.tensor(w.mean()), w.qualities);
    verdict = worst < 0 ? Verdict::inverts : Verdict::worsens_quality;
    if (worst >= 0 && worst >= std::min(old_worst, 0.6) && sum_of_inverses(w.qualities) < 0.999 * old_sum) {
      commit_move(w, w.ball, moved, w.qualities);
      return Verdict::accepted;
    }
  }
  return verdict;
}

}  // namespace weft::meshing
