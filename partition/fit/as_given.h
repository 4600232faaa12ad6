// An input that fits its metric already, as the result.
#pragma once

#include <optional>

#include "meshing/base/box.h"
#include "meshing/metric/fit.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

struct AsGiven {
  MeshPiece piece;  ///< the only one of this rank; its metric is scaled
  meshing::MetricFit fit;
  double complexity = 0;  ///< of the whole mesh in that metric
  meshing::Box box;       ///< of the whole mesh
};

/// All ranks: the mesh of the slices as one piece a rank, where it fits its metric, scaled to
/// `target_complexity` (0: as it is), in all its parts (meshing::fit_of()), and lacks nothing that adaptation
/// would complete (meshing::is_complete()); else empty, on all ranks. Points, tets, edges and corners keep
/// their order; triangles come in that of their first tets, as in all meshes that weft writes. Depends
/// neither on the number of ranks nor on the shares. Throws as check_slices() does.
std::optional<AsGiven> as_given(Peers& peers, const MeshSlice& slice, double target_complexity);

}  // namespace weft::partition
