// What smoothing minimises: the sum of inverse mean ratios of a ball as a function of its centre's position.
#pragma once

#include <span>
#include <vector>

#include "meshing/base/lanes.h"
#include "meshing/kernel/neighbourhood.h"
#include "meshing/kernel/quality.h"

namespace weft::meshing {

/// Value, gradient and Hessian of F(x) = sum over the ball of 1/Q, metrics frozen. 1/Q = S D^(-2/3) / c with
/// S quadratic and D linear in x, so all derivatives are closed forms.
struct BallDerivatives {
  double value = 0;
  Vec gradient;
  SymTensor hessian;
};

/// A ball as seen from its centre: the opposite faces, as arrays in which eight faces are worked on at once.
/// Gathered once per vertex, evaluated at several places.
class BallFaces {
 public:
  /// The faces opposite the centre of `ball`, with what MetricMean adds up at their vertices. `mesh` and
  /// `ball` must stay as they are while the faces are evaluated.
  void gather(MetricMean mean, const TetMesh& mesh, const Ball& ball);

  int size() const { return size_; }

  /// Derivatives at `x` where the centre has tensor `centre`. Tets that are not positive there contribute
  /// nothing.
  BallDerivatives derivatives(const Point& x, const SymTensor& centre);
  /// After derivatives(): 1/Q of face k (0 for a tet that is not positive) and its gradient.
  double value(int k) const { return row(kValue)[k]; }
  Vec gradient(int k) const { return {row(kGradient)[k], row(kGradient + 1)[k], row(kGradient + 2)[k]}; }

  /// Mean ratios of all tets with the centre at `x`; returns the least, or -1 when one is not exactly
  /// positive or its metrics have no mean that is positive definite in doubles.
  double qualities(const Point& x, const SymTensor& centre, std::vector<float>& qualities);

 private:
  // Rows of doubles, one entry a face, padded to whole groups of eight with copies of the last face.
  enum Row {
    kOrigin = 0,
    kEdge1 = 3,
    kEdge2 = 6,
    kNormal = 9,
    kAbsNormal = 12,
    kTensor = 15,
    kGathered = 21,  // the rows above are of the faces alone
    kMean = 21,
    kDeterminant = 27,  // of the mean, where it is the log-Euclidean one
    kValue = 28,
    kGradient = 29,
    kWeight = 32,
    kRows = 33
  };
  double* row(int r) { return data_.data() + r * stride_; }
  const double* row(int r) const { return data_.data() + r * stride_; }
  void set(int k, const TetMesh& mesh, VertexId a, VertexId b, VertexId c);
  void average(const SymTensor& centre);
  Lanes determinants(int k, const TensorLanes& mean) const;
  bool is_positive(int k, const Point& x) const;

  const TetMesh* mesh_ = nullptr;  // for the exact judge, of what has been gathered
  const Ball* ball_ = nullptr;
  MetricMean mean_ = MetricMean::arithmetic;
  int size_ = 0, stride_ = 0;
  std::vector<double> data_;
};

}  // namespace weft::meshing
