// What walls ask for, on a mesh in parts.
#pragma once

#include "meshing/metric/metric_field.h"
#include "partition/communication/peers.h"
#include "partition/metric/part_domain.h"
#include "partition/slice/mesh_slice.h"
#include "weft/data.h"

namespace weft::partition {

/// All ranks: meshing::wall_metric() of the mesh of all slices, at the vertices of this rank's part; the same
/// bits for any number of ranks and any shares. A rank has the triangles of walls at its own vertices and
/// asks others for those closest to the rest (communication/triangles_in_shares.h). Throws what
/// meshing::check_walls() throws, the same on all ranks.
meshing::LogMetricField wall_metric_in_parts(Peers& peers, const MeshSlice& slice, const PartDomain& domain,
                                             const WallOptions& options);

}  // namespace weft::partition
