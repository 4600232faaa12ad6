// A slice with the points that its tets have is a piece, and pieces can be measured.
#include "partition/fields/measure_slices.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/output/measure_pieces.h"
#include "partition/slice/fetched_points.h"
#include "partition/slice/used_numbers.h"

namespace weft::partition {
namespace {

using meshing::MeshData;
using meshing::Point;
using meshing::Tet;

std::uint32_t place_of(const std::vector<std::uint32_t>& numbers, std::uint32_t number) {
  return static_cast<std::uint32_t>(meshing::place_in(numbers, number));
}

/// The vertices of these tets and the slice's own points, ascending: every point of the mesh is somebody's.
std::vector<std::uint32_t> numbers_here(const MeshSlice& slice) {
  std::vector<std::uint32_t> numbers = used_numbers(slice.tets);
  for (std::size_t i = 0; i < slice.points.size(); ++i)
    numbers.push_back(static_cast<std::uint32_t>(slice.first_point + i));
  meshing::sort_unique(numbers);
  return numbers;
}

/// All ranks: who else has these points. Whoever has a point in its slice knows who asks for it.
std::vector<SubdomainStart::Shared> others_of(Peers& peers, const Ranges& points,
                                              const std::vector<std::uint32_t>& numbers) {
  std::vector<std::vector<std::uint32_t>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const std::uint32_t number : numbers) to_each[points.rank_of(number)].push_back(number);
  const auto asked = partition::all_to_all(peers, to_each);
  struct Holder {
    std::uint32_t number, rank;
    auto operator<=>(const Holder&) const = default;
  };
  std::vector<Holder> holders;
  for (std::uint32_t r = 0; r < asked.size(); ++r)
    for (const std::uint32_t number : asked[r]) holders.push_back({number, r});
  std::ranges::sort(holders);
  std::vector<std::vector<Holder>> answers(asked.size());
  for (std::uint32_t r = 0; r < asked.size(); ++r)
    for (const std::uint32_t number : asked[r])
      for (const Holder& holder : std::ranges::equal_range(holders, number, {}, &Holder::number))
        if (holder.rank != r) answers[r].push_back(holder);
  std::vector<SubdomainStart::Shared> shared;
  for (const auto& of_rank : partition::all_to_all(peers, answers))
    for (const Holder& holder : of_rank)
      shared.push_back({place_of(numbers, holder.number), SubdomainId(holder.rank)});
  std::ranges::sort(shared);
  return shared;
}

/// All ranks: the slice as a piece without triangles. No metric: that of the unit tensor.
MeshPiece piece_of(Peers& peers, const MeshSlice& slice, bool with_metric) {
  const Ranges points(peers, slice.points.size());
  const std::vector<std::uint32_t> numbers = numbers_here(slice);
  MeshPiece piece;
  piece.subdomain = SubdomainId(static_cast<std::uint32_t>(peers.rank()));
  piece.mesh.points = fetch<Point>(peers, points, numbers, [&](std::size_t i) { return slice.points[i]; });
  piece.mesh.point_refs.resize(numbers.size());
  piece.log_metrics.resize(numbers.size());
  if (with_metric)
    piece.log_metrics = fetch<meshing::LogMetric>(peers, points, numbers,
                                                  [&](std::size_t i) { return slice.log_metrics[i]; });
  for (const std::uint32_t number : numbers) piece.ids.emplace_back(SubdomainId(0), number);
  piece.shared = others_of(peers, points, numbers);
  piece.mesh.tets = slice.tets;
  for (Tet& tet : piece.mesh.tets)
    for (std::uint32_t& v : tet) v = place_of(numbers, v);
  piece.mesh.tet_refs = slice.tet_refs;
  return piece;
}

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
  MeshPiece piece = piece_of(peers, slice, true);
  if (target_complexity > 0) scale_together(peers, target_complexity, piece);
  meshing::Measures measures = measure_pieces(peers, {&piece, 1});
  measures.num_triangles = slice.num_triangles;
  return measures;
}

double complexity_of_slices(Peers& peers, const MeshSlice& slice) {
  const MeshPiece piece = piece_of(peers, slice, true);
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
  const MeshPiece piece = piece_of(peers, slice, false);
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
