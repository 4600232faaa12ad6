// What smoothing minimises: the sum of inverse mean ratios of a ball as a function of its centre's position.
#pragma once

#include <array>
#include <vector>

#include "meshing/neighbourhood.h"
#include "meshing/quality.h"

namespace weft::meshing {

/// Value, gradient and Hessian of F(x) = sum over the ball of 1/Q, metrics frozen. 1/Q = S D^(-2/3) / c with S quadratic
/// and D linear in x, so all derivatives are closed forms.
struct BallDerivatives {
  double value = 0;
  Vec gradient;
  SymTensor hessian;
};

/// One tet of a ball as seen from its centre: the opposite face and its share of the metric, gathered once.
struct BallFace {
  std::array<Point, 3> x;  ///< (x[0], x[1], x[2], centre) is positive
  SymTensor tensor;        ///< sum of what MetricMean adds up at the three
};

/// Gathers the faces opposite the centre of `ball`.
void gather_faces(const TetMesh& mesh, const Ball& ball, std::vector<BallFace>& faces);

/// Derivatives at `x` where the centre has tensor `m`. All tets must be positive there.
BallDerivatives ball_derivatives(MetricMean mean, const std::vector<BallFace>& faces, const Point& x, const SymTensor& m);

/// Qualities of all tets with the centre at `x`; returns the least, or -1 as soon as one is not exactly positive.
double ball_qualities(MetricMean mean, const std::vector<BallFace>& faces, const Point& x, const SymTensor& m, std::vector<float>& qualities);

}  // namespace weft::meshing
