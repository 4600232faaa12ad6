// A slice with the points that its tets have is a piece, and pieces can be measured.
#include "partition/fields/measure_slices.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <ranges>
#include <utility>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/output/measure_pieces.h"
#include "partition/slice/fetched_points.h"
#include "partition/slice/used_numbers.h"

namespace weft::partition {
namespace {

using meshing::MeshData;
using meshing::Point;
using meshing::Tet;

/// The vertices of these tets and the slice's own points, ascending: every point of the mesh is somebody's.
std::vector<std::uint32_t> numbers_here(const MeshSlice& slice) {
  const std::vector<std::uint32_t> used = used_numbers(slice.tets);
  const auto first = static_cast<std::uint32_t>(slice.first_point);
  const auto own = std::views::iota(first, first + static_cast<std::uint32_t>(slice.points.size()));
  std::vector<std::uint32_t> numbers;
  numbers.reserve(used.size() + own.size());
  std::ranges::set_union(used, own, std::back_inserter(numbers));
  return numbers;
}

/// All ranks: who else has these points. Whoever has a point in its slice knows who asks for it; most are
/// asked for by one rank alone.
std::vector<SubdomainStart::Shared> others_of(Peers& peers, const MeshSlice& slice, const Ranges& points,
                                              const std::vector<std::uint32_t>& numbers) {
  struct Holder {
    std::uint32_t number, rank;
    auto operator<=>(const Holder&) const = default;
  };
  const auto asked = sent_to_owners(peers, points, numbers);
  std::vector<std::uint8_t> users(slice.points.size(), 0);
  const auto users_of = [&](std::uint32_t number) -> std::uint8_t& {
    return users[number - slice.first_point];
  };
  for (const auto& of_rank : asked)
    for (const std::uint32_t number : of_rank)
      if (std::uint8_t& known = users_of(number); known < 2) ++known;
  std::vector<Holder> holders;
  const auto for_each_shared = [&](const auto& f) {
    for (std::uint32_t r = 0; r < asked.size(); ++r)
      for (const std::uint32_t number : asked[r])
        if (users_of(number) > 1) f(Holder{number, r});
  };
  for_each_shared([&](const Holder& holder) { holders.push_back(holder); });
  std::ranges::sort(holders);
  std::vector<std::vector<Holder>> answers(asked.size());
  for_each_shared([&](const Holder& asking) {
    for (const Holder& holder : std::ranges::equal_range(holders, asking.number, {}, &Holder::number))
      if (holder.rank != asking.rank) answers[asking.rank].push_back(holder);
  });
  PlacesOfNumbers places(numbers);
  std::vector<SubdomainStart::Shared> shared;
  for (const auto& of_rank : partition::all_to_all(peers, std::move(answers)))
    for (const Holder& holder : of_rank) shared.push_back({places(holder.number), SubdomainId(holder.rank)});
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
  piece.ids.reserve(numbers.size());
  for (const std::uint32_t number : numbers) piece.ids.emplace_back(SubdomainId(0), number);
  piece.shared = others_of(peers, slice, points, numbers);
  PlacesOfNumbers places(numbers);
  piece.mesh.tets.reserve(slice.tets.size());
  for (const Tet& tet : slice.tets) piece.mesh.tets.push_back(places(tet));
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
