// One look at each tet, a block at a time.
#include "meshing/metric/fit.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "meshing/base/parallel.h"
#include "meshing/metric/measure_lanes.h"

namespace weft::meshing {
namespace {

constexpr double kUnit = 4294967296.0;  // 2^32

/// Few tets of an adapted mesh, and of no block more than two, are as poor or have an edge as long, where
/// nothing could be mended; none is worse. A vertex whose metric asks for sizes eight times smaller has two
/// dozen.
constexpr double kFarQuality = 0.3, kFarLength = 1.8, kWrongQuality = 0.1, kWrongLength = 2.5;
constexpr std::uint64_t kMostFar = 8;

/// Limits of a block, from blocks of meshes that weft has adapted and from the same in metrics 5 % off: see
/// tests/experiments/2026-11-27-again-in-parts.md. Blocks with more short edges have more long ones too, but
/// where the metric asks for shorter ones: the share of long ones is limited by that of short ones.
constexpr double kMostShort = 0.042, kMostLong = 0.0005, kMostLongOfShort = 0.2, kLeastQuality = 0.87,
                 kLeastTets = 8.6, kMostTets = 12.3;

/// Sums of what is far beyond any block must not overflow.
std::uint64_t fixed(double value, double most) {
  return value > 0 ? static_cast<std::uint64_t>(std::llround(std::min(value, most) * kUnit)) : 0;
}

void add(const TetLanes& lanes, int count, FitSums& sums) {
  for (int i = 0; i < count; ++i) {
    double longest = 0;
    for (const Lanes& squares : lanes.squared_lengths) {
      sums.longer += squares[i] > 2;
      sums.shorter += squares[i] < 0.5;
      longest = std::max(longest, squares[i]);
    }
    const auto within = [&](double quality, double length) {
      return lanes.ratios[i] >= quality && longest <= length * length;
    };
    sums.far += !within(kWrongQuality, kWrongLength) ? kMostFar + 1 : !within(kFarQuality, kFarLength);
    sums.quality += fixed(lanes.ratios[i], 1);
    sums.volume += fixed(lanes.volumes[i], 1024);
  }
  sums.tets += static_cast<std::uint64_t>(count);
}

double share(std::uint64_t part, std::uint64_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0;
}

}  // namespace

FitSums& FitSums::operator+=(const FitSums& o) {
  tets += o.tets, longer += o.longer, shorter += o.shorter;
  far += o.far, quality += o.quality, volume += o.volume;
  return *this;
}

MetricFit FitSums::shares() const {
  return {share(longer, 6 * tets), share(shorter, 6 * tets), share(quality, tets) / kUnit,
          share(tets, volume) * kUnit};
}

bool FitSums::fits() const {
  const MetricFit fit = shares();
  return far <= kMostFar && fit.edges_short <= kMostShort &&
         fit.edges_long <= kMostLong + kMostLongOfShort * fit.edges_short &&
         fit.quality_mean >= kLeastQuality && fit.tets_of_complexity >= kLeastTets &&
         fit.tets_of_complexity <= kMostTets;
}

bool may_fit(std::uint64_t num_tets, double complexity) {
  constexpr double kMargin = 1.1;  // volumes are of tets' mean metrics, complexities of vertices'
  const auto tets = static_cast<double>(num_tets);
  return tets * kMargin >= kLeastTets * complexity && tets <= kMargin * kMostTets * complexity;
}

std::optional<FitBlocks> sum_blocks(std::span<const Tet> tets, std::uint64_t first_tet,
                                    std::uint64_t num_tets, std::span<const Point> points,
                                    std::span<const LogMetric> log_metrics) {
  const std::uint64_t blocks = blocks_of(num_tets), end_tet = first_tet + tets.size();
  if (blocks == 0) return {};
  FitBlocks result;
  if (tets.empty()) return result;
  const auto block_of = [&](std::uint64_t tet) { return std::min(tet / kTetsOfBlock, blocks - 1); };
  result.first = block_of(first_tet);
  result.sums.resize(block_of(end_tet - 1) + 1 - result.first);
  std::atomic<bool> fit = true;
  for_each_large(result.sums.size(), [&](std::size_t b) {
    if (!fit) return;
    const std::uint64_t first = first_of_block(result.first + b, num_tets),
                        last = first_of_block(result.first + b + 1, num_tets);
    const std::size_t begin = std::max(first, first_tet) - first_tet,
                      end = std::min(last, end_tet) - first_tet;
    FitSums& sums = result.sums[b];
    for (std::size_t t = begin; t < end; t += kLanes)
      add(measure_tets(tets, t, points, log_metrics),
          static_cast<int>(std::min<std::size_t>(kLanes, end - t)), sums);
    if (sums.tets == last - first && !sums.fits()) fit = false;
  });
  if (!fit) return {};
  return result;
}

Followers count_followers(std::span<const Tet> tets) {
  if (tets.empty()) return {};
  const auto joined = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(1, tets.size(), 1 << 14), std::uint64_t{0},
      [&](const tbb::blocked_range<std::size_t>& range, std::uint64_t count) {
        for (std::size_t t = range.begin(); t < range.end(); ++t)
          count += std::ranges::find_first_of(tets[t - 1], tets[t]) != tets[t - 1].end();
        return count;
      },
      std::plus<>());
  return {tets.size() - 1, joined};
}

std::optional<MetricFit> fit_of(const MeshData& mesh, std::span<const LogMetric> log_metrics) {
  const auto blocks = sum_blocks(mesh.tets, 0, mesh.tets.size(), mesh.points, log_metrics);
  if (!blocks || !count_followers(mesh.tets).in_order()) return {};
  FitSums all;
  for (const FitSums& sums : blocks->sums) all += sums;
  return all.shares();
}

}  // namespace weft::meshing
