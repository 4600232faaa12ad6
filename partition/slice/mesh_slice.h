// One rank's share of the input, as readers of files deliver it.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/base/sort_unique.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"

namespace weft::partition {

/// A contiguous share of the points, one of the tets, one of the triangles and one of the edges, in the order
/// of the ranks; any may be empty.
struct MeshSlice {
  std::uint64_t num_points = 0;                                  ///< of the whole mesh; below 2^32 - 1
  std::uint64_t num_tets = 0, num_triangles = 0, num_edges = 0;  ///< of the whole mesh

  std::uint64_t first_point = 0;  ///< number of points[0] in the whole mesh
  std::vector<meshing::Point> points;
  std::vector<std::int32_t> point_refs;
  meshing::LogMetricField log_metrics;  ///< of the target: scaled, limited and graded already

  std::uint64_t first_tet = 0;                     ///< number of tets[0] in the whole mesh
  std::vector<std::array<std::uint32_t, 4>> tets;  ///< vertices numbered as in the whole mesh
  std::vector<std::int32_t> tet_refs;

  std::uint64_t first_triangle = 0, first_edge = 0;  ///< numbers of boundary's in the whole mesh
  /// The share of triangles and edges with their references, contiguous shares of the lists of corners,
  /// ridges and what is required, and shares of the records of vertices on a CAD model; all of them, and
  /// vertices, by numbers in the whole mesh. No points and no tets. Given up when it is completed
  /// (boundary_share.h).
  meshing::MeshData boundary;
};

/// All ranks: counts the triangles and edges of all, from what is in `slice.boundary`.
inline void count_boundary(Peers& peers, MeshSlice& slice) {
  const Ranges triangles(peers, slice.boundary.triangles.size()), edges(peers, slice.boundary.edges.size());
  slice.num_triangles = triangles.total();
  slice.num_edges = edges.total();
  slice.first_triangle = triangles.first(peers.rank());
  slice.first_edge = edges.first(peers.rank());
}

/// All ranks: the vertices on the ranks' lists, each once, ascending over the ranks: at who has its point.
inline std::vector<std::uint32_t> each_at_its_point(Peers& peers, const Ranges& points,
                                                    const std::vector<std::uint32_t>& list) {
  std::vector<std::vector<std::uint32_t>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const std::uint32_t v : list) to_each[points.rank_of(v)].push_back(v);
  std::vector<std::uint32_t> here = all_to_all_joined(peers, std::move(to_each));
  meshing::sort_unique(here);
  return here;
}

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
