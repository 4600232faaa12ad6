// The sums that measures are made of: over any tets, over any edges, and put together.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// Counts a value by its place among the intervals of `h`: itself, its log10 where they are logarithmic (of
/// zero and of negative values anything below all of them).
inline void count(Histogram& h, double place) {
  const auto bins = static_cast<double>(h.counts.size());
  const double bin = (place - h.lo) / (h.hi - h.lo) * bins;
  if (!(bin >= 0))
    ++h.below;
  else if (bin > bins)
    ++h.above;
  else
    ++h.counts[std::min(static_cast<std::size_t>(bin), h.counts.size() - 1)];
}

/// All but the quantiles that Measures says of tets.
struct TetTotals {
  double volume = 0, complexity = 0, quality = 0;
  double quality_min = std::numeric_limits<double>::infinity();
  std::uint64_t below_01 = 0, below_02 = 0, above_08 = 0;
  Histogram linear = Measures{}.quality, logarithmic = Measures{}.quality_log;

  /// A mean ratio and its place among the logarithmic intervals (log10_for_bins).
  void add_quality(double q, double log10) {
    quality += q;
    quality_min = std::min(quality_min, q);
    below_01 += q < 0.1;
    below_02 += q < 0.2;
    above_08 += q > 0.8;
    count(linear, q);
    count(logarithmic, log10);
  }
  TetTotals& operator+=(const TetTotals& o) {
    volume += o.volume;
    complexity += o.complexity;
    quality += o.quality;
    quality_min = std::min(quality_min, o.quality_min);
    below_01 += o.below_01;
    below_02 += o.below_02;
    above_08 += o.above_08;
    linear += o.linear;
    logarithmic += o.logarithmic;
    return *this;
  }
};

/// All that Measures says of edges.
struct EdgeTotals {
  std::uint64_t edges = 0, unit = 0, shorter = 0, longer = 0;
  double length = 0, length_max = 0;
  double length_min = std::numeric_limits<double>::infinity();
  Histogram linear = Measures{}.length, logarithmic = Measures{}.length_log;

  static bool is_unit(double l) { return l >= 1 / std::numbers::sqrt2 && l <= std::numbers::sqrt2; }
  void add_length(double l, double log10) {
    ++edges;
    length += l;
    length_min = std::min(length_min, l);
    length_max = std::max(length_max, l);
    shorter += l < 1 / std::numbers::sqrt2;
    longer += l > std::numbers::sqrt2;
    unit += is_unit(l);
    count(linear, l);
    count(logarithmic, log10);
  }
  EdgeTotals& operator+=(const EdgeTotals& o) {
    edges += o.edges;
    unit += o.unit;
    shorter += o.shorter;
    longer += o.longer;
    length += o.length;
    length_min = std::min(length_min, o.length_min);
    length_max = std::max(length_max, o.length_max);
    linear += o.linear;
    logarithmic += o.logarithmic;
    return *this;
  }
};

/// Lengths of edges that are not unit, in any order; none where there are more than `most`.
struct OddLengths {
  std::size_t most = std::numeric_limits<std::size_t>::max();
  std::size_t count = 0;
  std::vector<double> values;

  void add(double length) {
    if (++count <= most)
      values.push_back(length);
    else
      values.clear();
  }
  OddLengths& operator+=(const OddLengths& o) {
    count += o.count;
    if (count <= most)
      values.insert(values.end(), o.values.begin(), o.values.end());
    else
      values.clear();
    return *this;
  }
};

/// Points, one a vertex, with what sums take from the metrics there.
struct MeasuredPoints {
  /// Of what stays as long as this. Multithreaded on TBB.
  MeasuredPoints(std::span<const Point> x, std::span<const LogMetric> log_metrics);

  std::span<const Point> x;
  std::span<const LogMetric> log_metrics;
  std::vector<double> densities;  ///< sqrt(det M)
  std::vector<Metric> metrics;
};

/// Sums over tets; qualities[t] becomes the mean ratio of tets[t]. Multithreaded on TBB; does not depend on
/// the number of threads.
TetTotals sum_tets(std::span<const std::array<std::uint32_t, 4>> tets, const MeasuredPoints& points,
                   std::vector<double>& qualities);

/// Sums over edges likewise: those with a flag (one an entry of edges.others), all without flags. `odd`,
/// where it is not null, becomes those of them that are not unit, up to odd->most.
EdgeTotals sum_edges(const EdgeLists& edges, std::span<const std::uint8_t> counted,
                     const MeasuredPoints& points, OddLengths* odd = nullptr);

/// What the sums over `num_tets` > 0 tets, or over at least one edge, say.
void put_tets(const TetTotals& totals, std::uint64_t num_tets, Measures& measures);
void put_edges(const EdgeTotals& totals, Measures& measures);

/// Of `n` > 0 values in ascending order, the index of quantile q (Measures).
std::uint64_t quantile_place(std::uint64_t n, double q);

}  // namespace weft::meshing
