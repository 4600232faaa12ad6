// Assembly by rows and Chebyshev iteration.
#include "meshing/mesh/mass_matrix.h"

#include <algorithm>

#include "meshing/base/parallel.h"

namespace weft::meshing {

MassMatrix::MassMatrix(const MeshData& mesh)
    : neighbours_(vertex_neighbours(mesh.tets, mesh.points.size())),
      off_diagonal_(neighbours_.items.size(), 0),
      diagonal_(mesh.points.size(), 0),
      lumped_(mesh.points.size(), 0) {
  const VertexLists tets = vertex_tets(mesh.tets, mesh.points.size());
  for_each_index(mesh.points.size(), [&](std::size_t v) {
    const auto row = neighbours_.of(v);
    for (const std::uint32_t t : tets.of(v)) {
      const auto& tet = mesh.tets[t];
      // A tet that is exactly positive may compute a negative volume.
      const double volume = std::max(
          0.0,
          six_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]) / 6);
      lumped_[v] += volume / 4;
      diagonal_[v] += volume / 10;
      for (const std::uint32_t w : tet) {
        if (w == v) continue;
        const auto at = std::ranges::lower_bound(row, w) - row.begin();
        off_diagonal_[neighbours_.begins[v] + static_cast<std::size_t>(at)] += volume / 20;
      }
    }
  });
}

/// (b - M x) over the diagonal.
void MassMatrix::residual(std::span<const double> b, std::size_t columns, std::span<const double> x,
                          std::span<double> scaled) const {
  for_each_index(diagonal_.size(), [&](std::size_t v) {
    const auto row = neighbours_.of(v);
    for (std::size_t c = 0; c < columns; ++c) {
      double sum = b[v * columns + c] - diagonal_[v] * x[v * columns + c];
      for (std::size_t i = 0; i < row.size(); ++i)
        sum -= off_diagonal_[neighbours_.begins[v] + i] * x[row[i] * columns + c];
      scaled[v * columns + c] = diagonal_[v] > 0 ? sum / diagonal_[v] : 0;
    }
  });
}

void MassMatrix::solve(std::span<const double> b, std::size_t columns, std::vector<double>& x,
                       const std::function<void(std::vector<double>& x)>& refresh) const {
  constexpr int kSteps = 32;
  constexpr double kMiddle = 1.5, kHalfWidth = 1;  // of the interval of the eigenvalues
  std::vector<double> r(x.size()), step(x.size(), 0);
  double alpha = 1 / kMiddle, beta = 0;
  for (int i = 0; i < kSteps; ++i) {
    residual(b, columns, x, r);
    for_each_index(x.size(), [&](std::size_t j) {
      step[j] = alpha * r[j] + beta * step[j];
      x[j] += step[j];
    });
    if (refresh) refresh(x);
    // Saad, Iterative Methods for Sparse Linear Systems (2003), algorithm 12.1, with step = alpha r + beta
    // step.
    const double half = 0.5 * kHalfWidth * alpha;
    const double b_next = i == 0 ? 2 * half * half : half * half;
    const double a_next = 1 / (kMiddle - b_next / alpha);
    beta = a_next * b_next / alpha;
    alpha = a_next;
  }
}

}  // namespace weft::meshing
