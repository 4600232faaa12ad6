// The whole mesh of all pieces in one place: for small results and for tests.
#pragma once

#include <span>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

struct MergedMesh {
  meshing::MeshData mesh;
  meshing::LogMetricField log_metrics;
};

/// All pieces of a result as one mesh, every entity once, in the order of number_pieces. Throws
/// meshing::InputError as number_pieces does, and for more points than 32 bits can number.
MergedMesh merge_pieces(std::span<const MeshPiece> pieces);

}  // namespace weft::partition
