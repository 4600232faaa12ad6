// The metric of first layers at walls.
#pragma once

#include <optional>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

/// At distance d from the nearest wall the size across it is h(d) = height + (growth - 1) d, the continuous
/// form of layers that grow geometrically, and along it the larger of `tangential` and h(d); none is larger
/// than largest_size. The direction across is that to the nearest point of the walls, on a wall its normal;
/// where walls meet at an angle the demands of all of them are intersected. O((n + w) log w) for w wall
/// triangles; multithreaded; does not depend on the number of threads. Throws InputError naming a reference
/// that no triangle has, and for a height that is not positive or a growth below 1. `largest`: largest_size
/// of the whole mesh, where this is a part of it.
LogMetricField wall_metric(const MeshData& mesh, const WallOptions& options,
                           std::optional<double> largest = std::nullopt);

}  // namespace weft::meshing
