// Measures of a mesh: one deterministic reduction over the tets, one over the edges.
#include "meshing/metric/measures.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "meshing/base/assert.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/tet_tables.h"
#include "meshing/metric/measure_lanes.h"
#include "meshing/metric/measure_totals.h"
#include "meshing/metric/metric_field.h"

namespace weft::meshing {
namespace {

using Range = tbb::blocked_range<std::size_t>;

/// Sums `Totals` over [0, n): accumulate(totals, begin, end) for parts, and += between them. The parts depend
/// on n only, so that rounding is the same for any number of threads.
template <class Totals, class Accumulate>
Totals reduce(std::size_t n, const Accumulate& accumulate) {
  return tbb::parallel_deterministic_reduce(
      Range(0, n, 1 << 13), Totals{},
      [&](const Range& range, Totals totals) {
        accumulate(totals, range.begin(), range.end());
        return totals;
      },
      [](Totals a, const Totals& b) {
        a += b;
        return a;
      });
}

double tet_volume(const Tet& tet, std::span<const Point> p) {
  return six_volume(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) / 6;
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
double tet_complexity(const Tet& tet, std::span<const Point> points, const std::vector<double>& densities) {
  const auto& [a, b, c, d] = tet;
  const double volume = std::max(0.0, tet_volume(tet, points));  // a flat one may compute a negative volume
  return 0.25 * volume * (densities[a] + densities[b] + densities[c] + densities[d]);
}

std::vector<Metric> metrics_of(std::span<const LogMetric> log_metrics) {
  std::vector<Metric> metrics(log_metrics.size());
  tbb::parallel_for(Range(0, metrics.size(), 1024), [&](const Range& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) metrics[i] = exp_fast(log_metrics[i]);
  });
  return metrics;
}

/// Moves quantile q of [0, n) to its place among the first `end` values, which hold it; the smaller ones stay
/// before it.
std::size_t select_quantile(std::vector<double>& values, std::size_t end, double q) {
  const auto place = static_cast<std::ptrdiff_t>(quantile_place(values.size(), q));
  std::nth_element(values.begin(), values.begin() + place, values.begin() + static_cast<std::ptrdiff_t>(end));
  return static_cast<std::size_t>(place);
}

/// The largest cosine of an angle between two faces of a tet; faces without area count for nothing.
double largest_dihedral_cosine(const Tet& tet, std::span<const Point> points) {
  std::array<Vec, 4> normals;
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& w = kTetFaces[f];
    const Point& a = points[tet[w[0]]];
    const Vec normal = cross(points[tet[w[1]]] - a, points[tet[w[2]]] - a);
    normals[f] = (1 / norm(normal)) * normal;
  }
  double largest = -1;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) largest = std::max(largest, -dot(normals[i], normals[j]));
  return largest;
}

double least_dihedral_degrees(const MeshData& mesh) {
  struct Largest {
    double cosine = -1;
    Largest& operator+=(const Largest& o) { return cosine = std::max(cosine, o.cosine), *this; }
  };
  const auto largest =
      reduce<Largest>(mesh.tets.size(), [&](Largest& all, std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) all += {largest_dihedral_cosine(mesh.tets[t], mesh.points)};
      });
  return std::acos(std::clamp(largest.cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

void measure_tets(const MeshData& mesh, const MeasuredPoints& points, Measures& m) {
  std::vector<double> qualities;
  put_tets(sum_tets(mesh.tets, points, qualities), mesh.tets.size(), m);
  const std::size_t q01 = select_quantile(qualities, qualities.size(), 0.01);
  m.quality_q01 = qualities[q01];
  m.quality_q001 = qualities[select_quantile(qualities, q01 + 1, 0.001)];
}

}  // namespace

MeasuredPoints::MeasuredPoints(std::span<const Point> points, std::span<const LogMetric> logs)
    : x(points), log_metrics(logs), densities(densities_of(logs)), metrics(metrics_of(logs)) {}

TetTotals sum_tets(std::span<const Tet> tets, const MeasuredPoints& points, std::vector<double>& qualities) {
  qualities.resize(tets.size());
  return reduce<TetTotals>(tets.size(), [&](TetTotals& sums, std::size_t begin, std::size_t end) {
    for (std::size_t first = begin; first < end; first += kLanes) {
      const Lanes ratios = mean_ratios(tets.first(end), first, points.x, points.log_metrics);
      const Lanes logs = log10_for_bins(ratios);
      for (std::size_t t = first; t < std::min(end, first + kLanes); ++t) {
        qualities[t] = ratios[static_cast<int>(t - first)];
        sums.volume += tet_volume(tets[t], points.x);
        sums.complexity += tet_complexity(tets[t], points.x, points.densities);
        sums.add_quality(qualities[t], logs[static_cast<int>(t - first)]);
      }
    }
  });
}

EdgeTotals sum_edges(const EdgeLists& edges, std::span<const std::uint8_t> counted,
                     const MeasuredPoints& points, OddLengths* odd) {
  struct Sums {
    EdgeTotals totals;
    OddLengths odd;
    Sums& operator+=(const Sums& o) {
      totals += o.totals;
      odd += o.odd;
      return *this;
    }
  };
  const std::size_t most_odd = odd ? odd->most : 0;
  Sums all = reduce<Sums>(points.x.size(), [&](Sums& sums, std::size_t begin, std::size_t end) {
    sums.odd.most = most_odd;
    EdgeBatch batch;
    const auto take = [&] {
      const int size = batch.size();
      const Lanes lengths = batch.take_lengths(), logs = log10_for_bins(lengths);
      for (int i = 0; i < size; ++i) {
        sums.totals.add_length(lengths[i], logs[i]);
        if (odd && !EdgeTotals::is_unit(lengths[i])) sums.odd.add(lengths[i]);
      }
    };
    for (std::size_t v = begin; v < end; ++v) {
      for (std::size_t e = edges.begins[v]; e < edges.begins[v + 1]; ++e) {
        const std::uint32_t w = edges.others[e];
        if (!counted.empty() && !counted[e]) continue;
        batch.add(points.x[w] - points.x[v], points.metrics[v], points.metrics[w]);
        if (batch.size() == kLanes) take();
      }
    }
    take();
  });
  if (odd) *odd = std::move(all.odd);
  return all.totals;
}

void put_tets(const TetTotals& totals, std::uint64_t num_tets, Measures& m) {
  const auto n = static_cast<double>(num_tets);
  m.volume = totals.volume;
  m.complexity = totals.complexity;
  m.quality_mean = totals.quality / n;
  m.quality_min = totals.quality_min;
  m.quality_below_01 = static_cast<double>(totals.below_01) / n;
  m.quality_below_02 = static_cast<double>(totals.below_02) / n;
  m.quality_above_08 = static_cast<double>(totals.above_08) / n;
  m.quality = totals.linear;
  m.quality_log = totals.logarithmic;
}

void put_edges(const EdgeTotals& totals, Measures& m) {
  const auto n = static_cast<double>(totals.edges);
  m.num_edges = totals.edges;
  m.length_mean = totals.length / n;
  m.length_min = totals.length_min;
  m.length_max = totals.length_max;
  m.edges_unit = static_cast<double>(totals.unit) / n;
  m.edges_short = static_cast<double>(totals.shorter) / n;
  m.edges_long = static_cast<double>(totals.longer) / n;
  m.length = totals.linear;
  m.length_log = totals.logarithmic;
}

std::uint64_t quantile_place(std::uint64_t n, double q) {
  return static_cast<std::uint64_t>(std::max(std::ceil(q * static_cast<double>(n)), 1.0)) - 1;
}

void Histogram::add(double value) { count(*this, logarithmic ? std::log10(value) : value); }

Histogram& Histogram::operator+=(const Histogram& other) {
  WEFT_ASSERT_LIGHT(counts.size() == other.counts.size(), "histograms of the same intervals");
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
  WEFT_ASSERT_LIGHT(log_metrics.size() == mesh.points.size(), "one value a vertex");
  Measures m;
  m.num_vertices = mesh.points.size();
  m.num_tets = mesh.tets.size();
  m.num_triangles = mesh.triangles.size();
  if (mesh.tets.empty()) return m;
  const MeasuredPoints points(mesh.points, log_metrics);
  measure_tets(mesh, points, m);
  put_edges(sum_edges(unique_edges(mesh.tets, mesh.points.size()), {}, points), m);
  return m;
}

ShapeMeasures measure_shape(const MeshData& mesh) {
  if (mesh.tets.empty()) return {};
  Measures m;
  const LogMetricField euclidean(mesh.points.size());
  measure_tets(mesh, {mesh.points, euclidean}, m);
  return {m.quality_mean, m.quality_min, m.quality_q01, least_dihedral_degrees(mesh)};
}

double complexity(const MeshData& mesh, std::span<const LogMetric> log_metrics) {
  WEFT_ASSERT_LIGHT(log_metrics.size() == mesh.points.size(), "one value a vertex");
  struct Sum {
    double value = 0;
    Sum& operator+=(const Sum& o) { return value += o.value, *this; }
  };
  const std::vector<double> densities = densities_of(log_metrics);
  return reduce<Sum>(mesh.tets.size(),
                     [&](Sum& sum, std::size_t begin, std::size_t end) {
                       for (std::size_t t = begin; t < end; ++t)
                         sum.value += tet_complexity(mesh.tets[t], mesh.points, densities);
                     })
      .value;
}

}  // namespace weft::meshing
