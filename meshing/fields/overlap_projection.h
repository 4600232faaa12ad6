// The conservative part of a transfer: L2 projection through the overlap of two meshes, bounded.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "meshing/base/value_table.h"
#include "meshing/fields/tensor_limiter.h"
#include "meshing/fields/tet_locator.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_domain.h"

namespace weft::meshing {

/// The integral over the whole mesh of each column, linear in each tet.
std::vector<double> integrals(const MetricDomain& domain, const ValueTable& table);

/// Replaces `table`, which holds the old values interpolated at the vertices of `to`, by their bounded L2
/// projection with the integrals `wanted` (see TransferMethod::conservative); `places` are tets of `from` at
/// the vertices of `to`. `from` need not be more of the old mesh than what the part `to` overlaps. The
/// columns of `tensors`, all positive definite, stay so (limit_tensors) instead of being bounded one by one.
/// Returns how far each column had to leave its bounds; nothing, and leaves `table` as it is, where `to` is
/// interrupted before the overlaps are known. Throws InputError for a tet of `to` without volume.
/// `from` may be null where `to` has no tets here. `old_is_read`: called once nothing of `from`, `old` and
/// `places` is read any more.
std::optional<std::vector<double>> project(const TetLocator* from, const ValueTable& old,
                                           const MetricDomain& to, std::span<const std::uint32_t> places,
                                           std::span<const double> wanted,
                                           std::span<const TensorColumns> tensors, ValueTable& table,
                                           const std::function<void()>& old_is_read = {});

}  // namespace weft::meshing
