// Laplace's equation with given values at some vertices, on a mesh in parts.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/metric/metric_domain.h"

namespace weft::partition {

/// How far the solver came.
struct Solved {
  int steps = 0;
  double reduction = 0;  ///< last residual over the first, in the norm of the inverse diagonal
};

/// Changes the values at vertices that are not `fixed` so that their rows of Laplace's equation hold:
/// conjugate gradients, preconditioned by the diagonal, without any rank seeing more than its part. Values
/// and `fixed` are at all vertices of the domain, those that are not owned as their owners have them. Sums
/// over ranks have no order (MetricDomain::sum), so values have the same bits for any number of ranks. All
/// parts call together.
Solved solve_harmonic(const meshing::MetricDomain& domain, const std::vector<std::uint8_t>& fixed,
                      double tolerance, int most_steps, std::vector<double>& values);

}  // namespace weft::partition
