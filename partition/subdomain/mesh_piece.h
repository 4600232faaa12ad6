// The result of one subdomain: a part of the mesh as plain arrays.
#pragma once

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
};

}  // namespace weft::partition
