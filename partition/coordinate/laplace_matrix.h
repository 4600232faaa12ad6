// The matrix of Laplace's equation with linear finite elements on a mesh of tets.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "meshing/mesh/adjacency.h"
#include "meshing/metric/metric_domain.h"

namespace weft::partition {

/// Rows of the vertices that a domain owns: entry (v, w) is the integral of the product of the gradients of
/// the hat functions of v and w. Rows are summed in the order of the whole mesh, so that they have the same
/// bits on whatever rank they are. Tets whose computed volume is not positive count for nothing.
class LaplaceMatrix {
 public:
  explicit LaplaceMatrix(const meshing::MetricDomain& domain);

  double diagonal(std::size_t v) const { return diagonal_[v]; }
  /// y[v] of all owned vertices; x at all vertices of the domain. Multithreaded.
  void multiply(std::span<const double> x, std::span<double> y) const;

 private:
  const meshing::MetricDomain& domain_;
  meshing::VertexLists neighbours_;
  std::vector<double> off_diagonal_;  ///< beside neighbours_.items
  std::vector<double> diagonal_;
};

}  // namespace weft::partition
