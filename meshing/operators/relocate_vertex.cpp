// Relocation of a vertex whose ball smoothing cannot repair, by Ceres' TinySolver.
#include "meshing/operators/relocate_vertex.h"

#include <ceres/tiny_solver.h>

#include <algorithm>

#include "meshing/kernel/ball_objective.h"
#include "meshing/operators/placement.h"

namespace weft::meshing {
namespace {

constexpr int kMaxBall = 64;

/// Residual k is 1/Q_k^2, so that the sum of squares is dominated by the worst tet. The parameters are
/// coordinates in the unit frame of the vertex's metric, in which an anisotropic ball is round.
class BallResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = kMaxBall, NUM_PARAMETERS = 3 };

  BallResiduals(BallFaces& faces, const Point& origin, const SymTensor& tensor, const Eigen3& frame)
      : faces_(faces), origin_(origin), tensor_(tensor) {
    for (int i = 0; i < 3; ++i) axes_[i] = (1 / std::sqrt(frame.values[i])) * frame.vectors[i];
  }

  Point position(const double* y) const {
    return origin_ + y[0] * axes_[0] + y[1] * axes_[1] + y[2] * axes_[2];
  }

  bool operator()(const double* y, double* residuals, double* jacobian) const {
    std::fill_n(residuals, kMaxBall, 0.0);
    if (jacobian) std::fill_n(jacobian, 3 * kMaxBall, 0.0);
    faces_.derivatives(position(y), tensor_);
    for (int k = 0; k < faces_.size(); ++k) {
      const double inverse = faces_.value(k);
      // An inverted tet contributes nothing to the derivatives; here it is a wall.
      residuals[k] = inverse > 0 ? inverse * inverse : 1e30;
      if (!jacobian || inverse <= 0) continue;
      for (int i = 0; i < 3; ++i)
        jacobian[kMaxBall * i + k] = 2 * inverse * dot(faces_.gradient(k), axes_[i]);
    }
    return true;
  }

 private:
  BallFaces& faces_;
  Point origin_;
  SymTensor tensor_;
  std::array<Vec, 3> axes_;
};

}  // namespace

Verdict relocate_vertex(Worker& w, VertexId v) {
  TetMesh& mesh = w.mesh;
  if (mesh.frozen(v)) return Verdict::frozen;
  if (const Verdict r = gather_ball(mesh, w.claims, v, w.ball); r != Verdict::accepted) return r;
  if (mesh.kind(v) != VertexKind::interior || mesh.fixed(v)) return Verdict::not_needed;
  if (w.ball.tets.size() > kMaxBall) return Verdict::too_large;
  w.faces.gather(w.mean(), mesh, w.ball);
  double old_worst = 1;
  for (const auto& [t, local] : w.ball.tets) old_worst = std::min<double>(old_worst, mesh.quality(t));
  const BallResiduals residuals(w.faces, mesh.point(v), judge_tensor(w.mean(), mesh, v),
                                eigen_decomposition(mesh.metric(v)));
  ceres::TinySolver<BallResiduals> solver;
  solver.options.max_num_iterations = 20;
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  solver.Solve(residuals, &y);
  MovedVertex moved;
  if (!y.allFinite() || y.squaredNorm() < 1e-6) return Verdict::not_needed;
  if (!move_to(w, v, MoveSpace{}, residuals.position(y.data()), moved)) return Verdict::leaves_surface;
  const double worst = w.faces.qualities(moved.x, moved.tensor(w.mean()), w.qualities);
  if (worst < 0) return Verdict::inverts;
  if (worst < old_worst + std::max(1e-3, 0.02 * old_worst)) return Verdict::worsens_quality;
  commit_move(w, w.ball, moved, w.qualities);
  return Verdict::accepted;
}

}  // namespace weft::meshing
