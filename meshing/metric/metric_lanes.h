// Logarithms and exponentials of symmetric tensors, eight at a time: for whole fields.
#pragma once

#include <array>
#include <span>

#include "meshing/base/lanes.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// Eigenvalues, in no order, and unit eigenvectors of eight symmetric tensors, by Jacobi's rotations: the
/// error of each is a few roundings of the tensor, and those of definite tensors keep their relative digits
/// where the tensor is graded. NaN where rotations have not converged.
struct EigenLanes {
  std::array<Lanes, 3> values;
  std::array<VecLanes, 3> vectors;
};
EigenLanes eigen_of_lanes(const TensorLanes& a);

/// log_of() each; those that are not clearly positive definite and finite are left out, and bit i of the
/// result is set for them.
unsigned logs_of(std::span<const SymTensor> metrics, std::span<LogMetric> logs);

/// exp_exact() each. At most eight.
void exps_of(std::span<const LogMetric> logs, std::span<Metric> metrics);

}  // namespace weft::meshing
