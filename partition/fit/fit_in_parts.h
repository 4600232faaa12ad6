// Whether a mesh in shares fits its metric.
#pragma once

#include <optional>

#include "meshing/metric/fit.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// All ranks: meshing::fit_of() of the mesh whose tets, in their order, are those of the ranks' pieces; the
/// same on all ranks and for any number of them. That tets follow each other is not looked at
/// (follow_each_other()). A rank stops at its first block that does not fit.
std::optional<meshing::MetricFit> fit_in_parts(Peers& peers, const MeshPiece& piece);

}  // namespace weft::partition
