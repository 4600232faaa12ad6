// B-splines and NURBS: curves and surfaces with their first two derivatives.
#pragma once

#include <cstddef>
#include <vector>

#include "meshing/geometry/model/geometry_model.h"

namespace weft::meshing {

/// The basis functions of one parameter. On each span between knots they are combinations of Bernstein
/// polynomials with weights not negative (Bezier extraction: Borden et al. 2011), which are kept: an
/// evaluation then divides by no differences of knots, and rounds like de Boor's algorithm.
class SplineBasis {
 public:
  explicit SplineBasis(const SplineKnots& knots);

  /// The functions that are not zero at a parameter, and their first two derivatives there.
  struct Values {
    std::size_t first = 0;  ///< of degree + 1 control points
    double d[3][kMostSplineDegree + 3];
  };
  std::size_t degree() const { return degree_; }
  std::size_t num_control() const { return num_control_; }
  double first() const { return breaks_.front(); }
  double last() const { return breaks_.back(); }
  /// Beyond the first and the last knot those of the nearest span; at a knot those of the span after it.
  void evaluate(double t, Values& values) const;

 private:
  std::size_t degree_ = 0, num_control_ = 0, stride_ = 0;
  bool is_bezier_ = true;           ///< the functions are the Bernstein polynomials
  std::vector<double> breaks_;      ///< knots, each once
  std::vector<std::size_t> first_;  ///< span -> its first control point
  std::vector<double> extraction_;  ///< span, Bernstein polynomial, basis function (stride_)
};

class SplineCurve {
 public:
  explicit SplineCurve(const CurveSpline& data);
  CurveJet evaluate(double t) const;
  double first() const { return basis_.first(); }
  double last() const { return basis_.last(); }

 private:
  SplineBasis basis_;
  std::vector<WeightedPoint> control_;
};

class SplineSurface {
 public:
  explicit SplineSurface(const SurfaceSpline& data);
  SurfaceJet evaluate(const Parameters& at) const;

 private:
  bool turned_ = false;        ///< v outside: sums are fewest with the higher degree inside
  SplineBasis outer_, inner_;  ///< u and v, unless turned
  std::vector<WeightedPoint> control_;
};

}  // namespace weft::meshing
