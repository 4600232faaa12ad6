// A quadratic fitted by least squares to values around a point.
#pragma once

#include <memory>
#include <optional>

#include "meshing/base/point.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// Fits f(d) - f(0) = g.d + d.H.d / 2 to points added one by one; reuse one object for many fits. The fit is
/// done in the principal axes of the points, scaled to equal spread: the quadratics are the same space there,
/// and points of a layer 1e5 times wider than thick determine them as well as those of a ball. A point at
/// distance r there has weight r^-2.
class QuadraticFit {
 public:
  QuadraticFit();
  ~QuadraticFit();
  QuadraticFit(const QuadraticFit&) = delete;
  QuadraticFit& operator=(const QuadraticFit&) = delete;

  void clear();
  /// A point at `offset` from the centre, whose value is `difference` more than the centre's.
  void add(const Vec& offset, double difference);
  /// H, or nothing where the points do not determine it safely: fewer than 9, or columns of the system that
  /// are combinations of others within 1 %.
  std::optional<SymTensor> hessian();
  /// H of least norm in the scaled axes among those that fit best: what to take where no more points are to
  /// be had. Zero without points.
  SymTensor least_norm_hessian();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace weft::meshing
