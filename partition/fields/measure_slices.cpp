// A slice becomes a piece, and pieces can be measured.
#include "partition/fields/measure_slices.h"

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/fields/slice_piece.h"
#include "partition/output/measure_pieces.h"
#include "partition/slice/fetched_points.h"

namespace weft::partition {
namespace {

using meshing::Point;

/// All ranks: the metric of a piece such that the complexity of all becomes `target`.
void scale_together(Peers& peers, double target, MeshPiece& piece) {
  const double here = meshing::complexity(piece.mesh, piece.log_metrics);
  const double all = ordered_sum(peers, {&here, 1});
  if (here > 0) meshing::scale_to_complexity(piece.mesh, target * (here / all), piece.log_metrics);
}

/// All ranks: the sums of all, in the order of the ranks.
std::map<std::int32_t, double> total(Peers& peers, const std::map<std::int32_t, double>& mine) {
  struct Row {
    double value;
    std::int64_t ref;
  };
  std::vector<Row> rows;
  for (const auto& [ref, value] : mine) rows.push_back({value, ref});
  std::map<std::int32_t, double> all;
  for (const auto& of_rank : partition::allgather(peers, rows))
    for (const Row& row : of_rank) all[static_cast<std::int32_t>(row.ref)] += row.value;
  return all;
}

/// Each rank looks at its share of the triangles.
std::map<std::int32_t, double> areas(Peers& peers, const MeshSlice& slice) {
  const auto& triangles = slice.boundary.triangles;
  const FetchedPoints points(peers, slice, Ranges(peers, slice.points.size()), triangles);
  std::map<std::int32_t, double> mine;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::array<Point, 3> x = points.of(triangles[t]);
    mine[slice.boundary.triangle_refs[t]] += norm(cross(x[1] - x[0], x[2] - x[0])) / 2;
  }
  return total(peers, mine);
}

}  // namespace

meshing::Measures measure_slices(Peers& peers, const MeshSlice& slice, double target_complexity) {
  MeshPiece piece = piece_of_slice(peers, slice).piece;
  if (target_complexity > 0) scale_together(peers, target_complexity, piece);
  meshing::Measures measures = measure_pieces(peers, {&piece, 1});
  measures.num_triangles = slice.num_triangles;
  return measures;
}

double complexity_of_slices(Peers& peers, const MeshSlice& slice) {
  const MeshPiece piece = piece_of_slice(peers, slice).piece;
  const double here = meshing::complexity(piece.mesh, piece.log_metrics);
  return ordered_sum(peers, {&here, 1});
}

SlicesGeometry measure_geometry_of_slices(Peers& peers, const MeshSlice& slice) {
  SlicesGeometry geometry;
  meshing::Box mine;
  for (const Point& p : slice.points) mine.include(p);
  geometry.box = common_box(peers, mine);
  geometry.area_by_ref = areas(peers, slice);
  if (slice.num_tets == 0) return geometry;
  const MeshPiece piece = piece_of_slice(peers, slice, SliceMetric::missing).piece;
  const meshing::Measures m = measure_pieces(peers, {&piece, 1});
  const double here =
      piece.mesh.tets.empty() ? 180 : meshing::measure_shape(piece.mesh).least_dihedral_degrees;
  geometry.shape = {m.quality_mean, m.quality_min, m.quality_q01, -partition::max(peers, -here)};
  std::map<std::int32_t, double> volumes;
  const auto& x = piece.mesh.points;
  for (std::size_t t = 0; t < piece.mesh.tets.size(); ++t) {
    const auto& [a, b, c, d] = piece.mesh.tets[t];
    volumes[piece.mesh.tet_refs[t]] += meshing::six_volume(x[a], x[b], x[c], x[d]) / 6;
  }
  geometry.volume_by_ref = total(peers, volumes);
  return geometry;
}

}  // namespace weft::partition
