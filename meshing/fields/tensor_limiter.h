// Keeps the projection of positive definite tensors definite, and their integral.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "meshing/base/value_table.h"
#include "meshing/mesh/mass_matrix.h"
#include "meshing/metric/metric_domain.h"

namespace weft::meshing {

/// Where a table holds a tensor (six columns from `first` on), the least and the largest eigenvalue of it.
struct TensorColumns {
  std::size_t first, least, largest;
};

/// Flux-corrected transport of tensors (Lohmann, Journal of Computational Physics 348, 2017). The lumped
/// projection of definite tensors consists of means of them: definite, but smeared. `table` holds the
/// consistent one, and each edge the flux of what differs; fluxes are reduced, by as much at both ends, where
/// a vertex would get an eigenvalue below the `lo` of `least` or above the `hi` of `largest`. `loads` are the
/// right sides of the projection. At last a congruence S T S^T near the identity gives the integral `wanted`
/// (six numbers, definite) where the volumes of the meshes differ. Guaranteed: definite tensors whose
/// integral is `wanted` up to rounding of its trace. Returns the largest change of each entry by the
/// congruence.
/// Rows of `mass` are complete for the vertices that `domain` owns; those are the ones that get values.
std::array<double, 6> limit_tensors(const MetricDomain& domain, const MassMatrix& mass,
                                    const TensorColumns& columns, std::span<const double> loads,
                                    std::span<const double> lo, std::span<const double> hi,
                                    std::span<const double> wanted, ValueTable& table);

}  // namespace weft::meshing
