// One rank's share of the input, as readers of files deliver it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"

namespace weft::partition {

/// A contiguous share of the points and one of the tets, in the order of the ranks; either may be empty.
struct MeshSlice {
  std::uint64_t num_points = 0;  ///< of the whole mesh; below 2^32 - 1
  std::uint64_t num_tets = 0;    ///< of the whole mesh

  std::uint64_t first_point = 0;  ///< number of points[0] in the whole mesh
  std::vector<meshing::Point> points;
  std::vector<std::int32_t> point_refs;
  meshing::LogMetricField log_metrics;  ///< of the target: scaled, limited and graded already

  std::uint64_t first_tet = 0;                     ///< number of tets[0] in the whole mesh
  std::vector<std::array<std::uint32_t, 4>> tets;  ///< vertices numbered as in the whole mesh
  std::vector<std::int32_t> tet_refs;

  /// The whole mesh's triangles, edges, references, ridges, corners and required entities, vertices numbered
  /// as in the whole mesh; no points and no tets. The same on every rank, until it is completed
  /// (boundary_share.h).
  meshing::MeshData boundary;
};

/// Points and tets alone, without references and metrics.
inline MeshSlice without_boundary(const MeshSlice& slice) {
  MeshSlice copy;
  copy.num_points = slice.num_points;
  copy.num_tets = slice.num_tets;
  copy.first_point = slice.first_point;
  copy.points = slice.points;
  copy.point_refs.resize(copy.points.size());
  copy.first_tet = slice.first_tet;
  copy.tets = slice.tets;
  copy.tet_refs.resize(copy.tets.size());
  return copy;
}

}  // namespace weft::partition
