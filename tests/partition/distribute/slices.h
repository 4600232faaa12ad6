// Cuts whole meshes into the ranks' shares.
#pragma once

#include <cstdint>
#include <random>

#include "partition/slice/mesh_slice.h"

namespace weft::support {

/// A mesh and its metric.
struct MetricMesh {
  meshing::MeshData mesh;
  meshing::LogMetricField log_metrics;
};

/// Where shares begin: even, or drawn by `seed` such that some are empty and some large.
inline std::uint64_t share_begin(std::uint64_t count, int rank, int ranks, unsigned seed) {
  const auto even = count * static_cast<std::uint64_t>(rank) / static_cast<std::uint64_t>(ranks);
  if (seed == 0 || rank == 0 || rank == ranks) return even;
  std::vector<std::uint64_t> cuts;
  std::mt19937 random(seed);
  for (int r = 1; r < ranks; ++r) cuts.push_back(random() % 3 == 0 ? count : random() % (count + 1));
  std::sort(cuts.begin(), cuts.end());
  return cuts[static_cast<std::size_t>(rank - 1)];
}

inline partition::MeshSlice slice_of(const MetricMesh& whole, int rank, int ranks, unsigned seed = 0) {
  const meshing::MeshData& m = whole.mesh;
  partition::MeshSlice slice;
  slice.num_points = m.points.size();
  slice.num_tets = m.tets.size();
  slice.first_point = share_begin(m.points.size(), rank, ranks, seed);
  slice.first_tet = share_begin(m.tets.size(), rank, ranks, seed);
  const auto cut = [](const auto& array, std::uint64_t begin, std::uint64_t end) {
    const auto clamp = [&](std::uint64_t i) {
      return array.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(i, array.size()));
    };
    return std::decay_t<decltype(array)>(clamp(begin), clamp(end));
  };
  const std::uint64_t end_point = share_begin(m.points.size(), rank + 1, ranks, seed);
  const std::uint64_t end_tet = share_begin(m.tets.size(), rank + 1, ranks, seed);
  slice.points = cut(m.points, slice.first_point, end_point);
  slice.point_refs = cut(m.point_refs, slice.first_point, end_point);
  slice.log_metrics = cut(whole.log_metrics, slice.first_point, end_point);
  slice.tets = cut(m.tets, slice.first_tet, end_tet);
  slice.tet_refs = cut(m.tet_refs, slice.first_tet, end_tet);
  const auto share = [&](const auto& array) {
    return cut(array, share_begin(array.size(), rank, ranks, seed),
               share_begin(array.size(), rank + 1, ranks, seed));
  };
  slice.num_triangles = m.triangles.size();
  slice.num_edges = m.edges.size();
  slice.first_triangle = share_begin(m.triangles.size(), rank, ranks, seed);
  slice.first_edge = share_begin(m.edges.size(), rank, ranks, seed);
  // References too many are the last rank's.
  const auto refs_of = [&](const auto& refs, std::size_t count) {
    return cut(refs, share_begin(count, rank, ranks, seed),
               rank + 1 == ranks ? refs.size() : share_begin(count, rank + 1, ranks, seed));
  };
  slice.boundary.triangles = share(m.triangles);
  slice.boundary.triangle_refs = refs_of(m.triangle_refs, m.triangles.size());
  slice.boundary.edges = share(m.edges);
  slice.boundary.edge_refs = refs_of(m.edge_refs, m.edges.size());
  slice.boundary.ridges = share(m.ridges);
  slice.boundary.required_edges = share(m.required_edges);
  slice.boundary.required_triangles = share(m.required_triangles);
  slice.boundary.association.nodes = share(m.association.nodes);
  slice.boundary.association.edges = share(m.association.edges);
  slice.boundary.association.faces = share(m.association.faces);
  slice.boundary.corners = share(m.corners);
  slice.boundary.required_points = share(m.required_points);
  return slice;
}

}  // namespace weft::support
