// What the partitioners want to know of the tets of a mesh.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/metric/metric.h"

namespace weft::partition {

using TetCorners = std::array<meshing::Point, 4>;

/// sqrt(det M), from log M.
double density(const meshing::LogMetric& log_metric);
/// What a tet adds to the complexity of the mesh, from the densities at its corners: the quadrature that
/// defines it. Finite; 0 where the volume computes so.
double complexity(const TetCorners& tet, const std::array<double, 4>& densities);

/// The mean of exp over a tet, of a function that is linear on it and `x` at the corners: 3! exp[x0, x1, x2,
/// x3], the divided difference (Hermite and Genocchi). To 1e-9 of it, and finite.
double mean_of_exp(std::array<double, 4> x);
/// What the metric wants in a tet, where log M is linear between the corners, as the kernel reads it. Less
/// than the quadrature, which gives a tet between very different sizes too much: of one corner with 1,000
/// times the density of the others 25 % of it, where the integral has 1.8 %. Finite, as above.
double expected_complexity(const TetCorners& tet, const std::array<meshing::LogMetric, 4>& log_metrics);

/// M^-1 of determinant 1, from log M.
meshing::SymTensor unit_inverse(const meshing::LogMetric& log_metric);

/// Areas of the faces opposite each corner in M: `inverse` is its unit_inverse, `scale` det(M)^(1/3).
std::array<float, 4> face_areas(const TetCorners& tet, const meshing::SymTensor& inverse, double scale);

/// The number of vertices that the metric wants on a face, from what its two tets say of its area there (not
/// positive or NaN: 0): the mean over that of two unit triangles, since a surface has two for a vertex.
double vertices_wanted(float area, float other_area);

/// T such that n.T.n is in proportion to the square of the metric area of a cut with normal n through a mesh
/// of tets like this, per unit of area. A cut follows faces. Where the tet is equilateral these turn to all
/// sides of the cut, so that the faces' metric areas squared, which are quadratic in their normals, are in
/// the mean those of n and a share that is isotropic: T = S + tr(S M0) M0^-1 / 2, S = `inverse`, M's
/// unit_inverse, M0 the metric in which the tet is equilateral. Without the second term cuts through a mesh
/// of isotropic tets would be planned for a plane that its faces cannot follow. (Half: cuts around whole
/// balls of vertices; a quarter and all of it make 2 to 14 % more area on a uniform cube in polar-2.)
meshing::SymTensor cut_tensor(const TetCorners& tet, const meshing::SymTensor& inverse);

/// The number of tets that is expected of each: 12 times what is wanted in it, and a tenth for handling it.
std::vector<double> work_of(std::span<const double> expected_complexities);

/// What a decomposition wants to know of tets, an entry for each in every array.
struct TetMeasures {
  std::vector<meshing::Point> centres;
  std::vector<TetCorners> corners;
  std::vector<double> complexities;              ///< expected_complexity()
  std::vector<meshing::SymTensor> cut_tensors;   ///< Items::cut_tensors
  std::vector<std::array<float, 4>> face_areas;  ///< Items::face_areas

  void reserve(std::size_t tets);
  /// `complexity`: its expected_complexity().
  void add(const TetCorners& tet, const std::array<meshing::LogMetric, 4>& log_metrics, double complexity);
  /// The metric is that of `factor` times the complexity.
  void scale(double factor);
  std::vector<double> work() const { return work_of(complexities); }
};

}  // namespace weft::partition
