// The cheapest questions first.
#include "partition/fit/as_given.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/metric/metric.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/decompose/runs.h"
#include "partition/decompose/tet_measures.h"
#include "partition/fields/slice_piece.h"
#include "partition/fit/fit_in_parts.h"
#include "partition/fit/given_boundary.h"
#include "partition/slice/slice_checks.h"
#include "partition/verify/check_result.h"

namespace weft::partition {
namespace {

/// All ranks: what distribute() finds.
double complexity_of(Peers& peers, const MeshPiece& piece) {
  const auto& mesh = piece.mesh;
  std::vector<double> densities(mesh.points.size()), complexities(mesh.tets.size());
  meshing::for_each_index(densities.size(),
                          [&](std::size_t v) { densities[v] = density(piece.log_metrics[v]); });
  meshing::for_each_index(complexities.size(), [&](std::size_t t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    const auto& x = mesh.points;
    complexities[t] =
        complexity({x[a], x[b], x[c], x[d]}, {densities[a], densities[b], densities[c], densities[d]});
  });
  return ordered_sum(peers, complexities);
}

/// M <- factor^(2/3) M.
void scale(double factor, MeshPiece& piece) {
  const meshing::LogMetric shift =
      (2.0 / 3 * std::log(factor)) * meshing::LogMetric(meshing::identity_tensor(1));
  for (meshing::LogMetric& l : piece.log_metrics) l = l + shift;
}

std::vector<std::uint32_t> ends_of_edges(const MeshSlice& slice) {
  std::vector<std::uint32_t> ends;
  for (const auto& edge : slice.boundary.edges) ends.insert(ends.end(), edge.begin(), edge.end());
  return ends;
}

}  // namespace

std::optional<AsGiven> as_given(Peers& peers, const MeshSlice& slice, double target_complexity) {
  const Ranges points(peers, slice.points.size()), tets(peers, slice.tets.size());
  check_slices(peers, slice, points, tets);
  if (meshing::blocks_of(slice.num_tets) == 0) return {};
  if (target_complexity > 0 && !meshing::may_fit(slice.num_tets, target_complexity)) return {};
  if (!follow_each_other(peers, slice.tets)) return {};
  if (partition::max(peers, slice.boundary.association.empty() ? 0 : 1) > 0) return {};
  AsGiven result;
  SlicePiece made = piece_of_slice(peers, slice, SliceMetric::given, ends_of_edges(slice));
  result.piece = std::move(made.piece);
  result.complexity = complexity_of(peers, result.piece);
  if (target_complexity > 0 && result.complexity > 0) {
    scale(target_complexity / result.complexity, result.piece);
    result.complexity = target_complexity;
  }
  const auto fit = fit_in_parts(peers, result.piece);
  if (!fit || !take_given_boundary(peers, slice, made.numbers, result.piece)) return {};
  if (!conforms(peers, {&result.piece, 1})) return {};
  result.fit = *fit;
  meshing::Box mine;
  for (const meshing::Point& p : slice.points) mine.include(p);
  result.box = common_box(peers, mine);
  return result;
}

}  // namespace weft::partition
