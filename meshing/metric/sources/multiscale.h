// The multiscale metric: the one whose unit mesh of a given size interpolates a field best.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "meshing/metric/metric_field.h"
#include "meshing/metric/sources/hessian.h"
#include "weft/data.h"

namespace weft::meshing {

/// det|H|^(-1/(2p + 3)) |H|, H the Hessian of `values` (one a vertex) and |H| that of its absolute
/// eigenvalues: the optimal metric of Loseille and Alauzet (2011) up to a factor, which a target
/// complexity fixes. Eigenvalues that rounding of the values could make (4e-12 of the largest value over the
/// square of the longest edge at the vertex) are raised to that, so that the metric is positive definite for
/// any finite field, a constant one too. Does not depend on the field's units. Throws InputError for a value
/// that is not finite (naming the vertex, 1-based) or a norm below 1. Cost: that of recover_hessians.
/// On a part of a mesh: at all its vertices, from the rings of tets that rings_of() says around those it
/// owns.
LogMetricField multiscale_metric(const MetricDomain& domain, std::span<const double> values,
                                 const MultiscaleOptions& options);
LogMetricField multiscale_metric(const MeshData& mesh, std::span<const double> values,
                                 const MultiscaleOptions& options);

/// The scalar fields of a solution, in its order. Throws InputError naming `file` when there is none, when
/// the number of vertices is not `num_points` ("solution of another mesh"), and for a value that is not
/// finite (naming field and vertex, 1-based). `first`: the number of the first vertex, for messages.
std::vector<std::span<const double>> scalar_fields(const SolutionData& solution, std::size_t num_points,
                                                   const std::string& file, std::uint64_t first = 0);

}  // namespace weft::meshing
