// A ball's qualities as residuals for Ceres' TinySolver.
#include "meshing/operators/best_place.h"

#include <ceres/tiny_solver.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace weft::meshing {
namespace {

/// Residual k is 1/Q_k^2, so that the sum of squares is dominated by the worst tet. The parameters are
/// coordinates in the unit frame of the centre's metric, in which an anisotropic ball is round.
class BallResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = kMostFaces, NUM_PARAMETERS = 3 };

  BallResiduals(BallFaces& faces, const Point& origin, const SymTensor& tensor, const Eigen3& frame)
      : faces_(faces), origin_(origin), tensor_(tensor) {
    for (int i = 0; i < 3; ++i) axes_[i] = (1 / std::sqrt(frame.values[i])) * frame.vectors[i];
  }

  Point position(const double* y) const {
    return origin_ + y[0] * axes_[0] + y[1] * axes_[1] + y[2] * axes_[2];
  }

  bool operator()(const double* y, double* residuals, double* jacobian) const {
    std::fill_n(residuals, kMostFaces, 0.0);
    if (jacobian) std::fill_n(jacobian, 3 * kMostFaces, 0.0);
    faces_.derivatives(position(y), tensor_);
    for (int k = 0; k < faces_.size(); ++k) {
      const double inverse = faces_.value(k);
      // An inverted tet contributes nothing to the derivatives; here it is a wall.
      residuals[k] = inverse > 0 ? inverse * inverse : 1e30;
      if (!jacobian || inverse <= 0) continue;
      for (int i = 0; i < 3; ++i)
        jacobian[kMostFaces * i + k] = 2 * inverse * dot(faces_.gradient(k), axes_[i]);
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

std::optional<Point> best_place(BallFaces& faces, const Point& from, const Metric& metric,
                                const SymTensor& tensor) {
  const BallResiduals residuals(faces, from, tensor, eigen_decomposition(metric));
  ceres::TinySolver<BallResiduals> solver;
  solver.options.max_num_iterations = 20;
  Eigen::Vector3d y = Eigen::Vector3d::Zero();
  solver.Solve(residuals, &y);
  if (!y.allFinite() || y.squaredNorm() < 1e-6) return std::nullopt;
  return residuals.position(y.data());
}

}  // namespace weft::meshing
