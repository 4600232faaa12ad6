// Measures of a mesh: one deterministic reduction over the tets, one over the edges.
#include "meshing/measures.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "meshing/adjacency.h"

namespace weft::meshing {
namespace {

using Range = tbb::blocked_range<std::size_t>;

/// Sums `Totals` over [0, n): accumulate(totals, i) for each i, and += between parts. The parts depend on n
/// only, so that rounding is the same for any number of threads.
template <class Totals, class Accumulate>
Totals reduce(std::size_t n, const Accumulate& accumulate) {
  return tbb::parallel_deterministic_reduce(
      Range(0, n, 1 << 13), Totals{},
      [&](const Range& range, Totals totals) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) accumulate(totals, i);
        return totals;
      },
      [](Totals a, const Totals& b) {
        a += b;
        return a;
      });
}

double tet_volume(const MeshData& mesh, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return six_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) / 6;
}

/// sqrt(det M) at every vertex.
std::vector<double> densities_of(std::span<const LogMetric> log_metrics) {
  std::vector<double> densities(log_metrics.size());
  tbb::parallel_for(Range(0, densities.size(), 4096), [&](const Range& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      densities[i] = std::exp(0.5 * trace(log_metrics[i]));
  });
  return densities;
}

/// What a tet adds to the complexity. Summed by tets, not by vertices, so that no order of summation at a
/// vertex has to be kept.
double tet_complexity(const MeshData& mesh, const std::vector<double>& densities, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return 0.25 * tet_volume(mesh, t) * (densities[a] + densities[b] + densities[c] + densities[d]);
}

struct TetTotals {
  double volume = 0, complexity = 0, quality = 0;
  double quality_min = std::numeric_limits<double>::infinity();
  std::uint64_t below_01 = 0, below_02 = 0, above_08 = 0;
  Histogram linear = Measures{}.quality, logarithmic = Measures{}.quality_log;

  void add_quality(double q) {
    quality += q;
    quality_min = std::min(quality_min, q);
    below_01 += q < 0.1;
    below_02 += q < 0.2;
    above_08 += q > 0.8;
    linear.add(q);
    logarithmic.add(q);
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

struct EdgeTotals {
  std::uint64_t edges = 0, unit = 0, shorter = 0, longer = 0;
  double length = 0, length_max = 0;
  double length_min = std::numeric_limits<double>::infinity();
  Histogram linear = Measures{}.length, logarithmic = Measures{}.length_log;

  void add_length(double l) {
    ++edges;
    length += l;
    length_min = std::min(length_min, l);
    length_max = std::max(length_max, l);
    shorter += l < 1 / std::numbers::sqrt2;
    longer += l > std::numbers::sqrt2;
    unit += l >= 1 / std::numbers::sqrt2 && l <= std::numbers::sqrt2;
    linear.add(l);
    logarithmic.add(l);
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

/// Of the values in their order, the one at the share q of [0, end); leaves the smaller ones before it.
std::size_t select_quantile(std::vector<double>& values, std::size_t end, double q) {
  const auto rank = std::max(std::ceil(q * static_cast<double>(values.size())), 1.0);
  const std::size_t place = static_cast<std::size_t>(rank) - 1;
  std::nth_element(values.begin(), values.begin() + place, values.begin() + end);
  return place;
}

void measure_tets(const MeshData& mesh, std::span<const LogMetric> log_metrics, Measures& m) {
  std::vector<double> qualities(mesh.tets.size());
  const std::vector<double> densities = densities_of(log_metrics);
  TetTotals totals = reduce<TetTotals>(mesh.tets.size(), [&](TetTotals& sums, std::size_t t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    const auto& p = mesh.points;
    const auto& l = log_metrics;
    qualities[t] = mean_ratio({p[a], p[b], p[c], p[d]}, {l[a], l[b], l[c], l[d]});
    sums.volume += tet_volume(mesh, t);
    sums.complexity += tet_complexity(mesh, densities, t);
    sums.add_quality(qualities[t]);
  });
  const auto n = static_cast<double>(mesh.tets.size());
  m.volume = totals.volume;
  m.complexity = totals.complexity;
  m.quality_mean = totals.quality / n;
  m.quality_min = totals.quality_min;
  m.quality_below_01 = static_cast<double>(totals.below_01) / n;
  m.quality_below_02 = static_cast<double>(totals.below_02) / n;
  m.quality_above_08 = static_cast<double>(totals.above_08) / n;
  m.quality = std::move(totals.linear);
  m.quality_log = std::move(totals.logarithmic);
  const std::size_t q01 = select_quantile(qualities, qualities.size(), 0.01);
  m.quality_q01 = qualities[q01];
  m.quality_q001 = qualities[select_quantile(qualities, q01 + 1, 0.001)];
}

std::vector<Metric> metrics_of(std::span<const LogMetric> log_metrics) {
  std::vector<Metric> metrics(log_metrics.size());
  tbb::parallel_for(Range(0, metrics.size(), 1024), [&](const Range& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) metrics[i] = exp_fast(log_metrics[i]);
  });
  return metrics;
}

void measure_edges(const MeshData& mesh, std::span<const LogMetric> log_metrics, Measures& m) {
  const EdgeLists edges = unique_edges(mesh.tets, mesh.points.size());
  const std::vector<Metric> metrics = metrics_of(log_metrics);
  EdgeTotals totals = reduce<EdgeTotals>(mesh.points.size(), [&](EdgeTotals& sums, std::size_t v) {
    for (const std::uint32_t w : edges.of(static_cast<std::uint32_t>(v)))
      sums.add_length(edge_length(mesh.points[w] - mesh.points[v], metrics[v], metrics[w]));
  });
  const auto n = static_cast<double>(totals.edges);
  m.num_edges = totals.edges;
  m.length_mean = totals.length / n;
  m.length_min = totals.length_min;
  m.length_max = totals.length_max;
  m.edges_unit = static_cast<double>(totals.unit) / n;
  m.edges_short = static_cast<double>(totals.shorter) / n;
  m.edges_long = static_cast<double>(totals.longer) / n;
  m.length = std::move(totals.linear);
  m.length_log = std::move(totals.logarithmic);
}

}  // namespace

void Histogram::add(double value) {
  const double x = logarithmic ? std::log10(value) : value;  // of zero: below; of a negative value: NaN
  const auto bins = static_cast<double>(counts.size());
  const double bin = (x - lo) / (hi - lo) * bins;
  if (!(bin >= 0))
    ++below;
  else if (bin > bins)
    ++above;
  else
    ++counts[std::min(static_cast<std::size_t>(bin), counts.size() - 1)];
}

Histogram& Histogram::operator+=(const Histogram& other) {
  assert(counts.size() == other.counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += other.counts[i];
  below += other.below;
  above += other.above;
  return *this;
}

double mean_ratio(const std::array<Point, 4>& points, const std::array<LogMetric, 4>& log_metrics) {
  const LogMetric mean = 0.25 * (log_metrics[0] + log_metrics[1] + log_metrics[2] + log_metrics[3]);
  const Metric metric = exp_fast(mean);
  double squared_edges = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) squared_edges += squared_length(metric, points[j] - points[i]);
  const double volume = six_volume(points[0], points[1], points[2], points[3]) / 6;
  // (V sqrt(det M))^(2/3), with det M = exp(trace(log M)).
  const double size = std::cbrt(volume * volume) * std::exp(trace(mean) / 3);
  // At most 1 but for rounding, which must not show in the histograms.
  return std::copysign(std::min(kMeanRatioFactor * size / squared_edges, 1.0), volume);
}

Measures measure(const MeshData& mesh, std::span<const LogMetric> log_metrics) {
  assert(log_metrics.size() == mesh.points.size());
  Measures m;
  m.num_vertices = mesh.points.size();
  m.num_tets = mesh.tets.size();
  m.num_triangles = mesh.triangles.size();
  if (mesh.tets.empty()) return m;
  measure_tets(mesh, log_metrics, m);
  measure_edges(mesh, log_metrics, m);
  return m;
}

double complexity(const MeshData& mesh, std::span<const LogMetric> log_metrics) {
  assert(log_metrics.size() == mesh.points.size());
  struct Sum {
    double value = 0;
    Sum& operator+=(const Sum& o) { return value += o.value, *this; }
  };
  const std::vector<double> densities = densities_of(log_metrics);
  return reduce<Sum>(mesh.tets.size(),
                     [&](Sum& sum, std::size_t t) { sum.value += tet_complexity(mesh, densities, t); })
      .value;
}

}  // namespace weft::meshing
