// The mass matrix of linear elements: integrals of products of hat functions.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Multithreaded on TBB; no result depends on the number of threads.
class MassMatrix {
 public:
  /// Memory: 190 bytes a vertex. Every tet must have a positive volume.
  explicit MassMatrix(const MeshData& mesh);

  /// Sums of the rows: the lumped masses. Zero for a vertex without tets.
  std::span<const double> lumped() const { return lumped_; }
  /// Solves M x = b for `columns` right sides at once (value of vertex v and column c at v * columns + c),
  /// starting from the x given. The Jacobi-scaled matrix has its eigenvalues in [1/2, 5/2] on every mesh of
  /// tets (Wathen 1987), so that Chebyshev's iteration needs no inner products and reduces the error by 0.38
  /// a step: to 1e-13 of the first one here. Values of vertices without tets stay. Where the mesh is a part
  /// of another, `refresh` brings the x of vertices whose rows are not complete here, after every step.
  void solve(std::span<const double> b, std::size_t columns, std::vector<double>& x,
             const std::function<void(std::vector<double>& x)>& refresh = {}) const;
  /// Calls visit(w, entry) for the entries beside the diagonal of row v.
  template <class Visit>
  void for_each_in_row(std::size_t v, const Visit& visit) const {
    for (std::size_t i = neighbours_.begins[v]; i < neighbours_.begins[v + 1]; ++i)
      visit(neighbours_.items[i], off_diagonal_[i]);
  }

 private:
  void residual(std::span<const double> b, std::size_t columns, std::span<const double> x,
                std::span<double> scaled) const;

  VertexLists neighbours_;
  std::vector<double> off_diagonal_;  ///< beside neighbours_.items
  std::vector<double> diagonal_, lumped_;
};

}  // namespace weft::meshing
