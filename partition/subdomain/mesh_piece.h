// The result of one subdomain: a part of the mesh as plain arrays.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/subdomain/global_id.h"
#include "partition/subdomain/subdomain_start.h"

namespace weft::partition {

/// A part of the result mesh. Every tet of the result is in one piece; a vertex, a feature edge or a triangle
/// (of a material interface) may be in several.
struct MeshPiece {
  SubdomainId subdomain;
  meshing::MeshData mesh;  ///< local indices
  meshing::LogMetricField log_metrics;
  std::vector<GlobalId> ids;                   ///< of mesh.points
  std::vector<SubdomainStart::Shared> shared;  ///< vertices that other pieces have too, sorted
  /// 1 for the points and the edges that this piece writes, of a mesh that keeps the order that it came in.
  /// Empty, in all pieces: the lowest one that has them does.
  std::vector<std::uint8_t> own_points = {}, own_edges = {};
};

}  // namespace weft::partition
