// Sums of what went are taken off, sums of what came are added.
#include "meshing/metric/measure_again.h"

#include <algorithm>
#include <iterator>

#include "meshing/mesh/adjacency.h"

namespace weft::meshing {
namespace {

/// Some tets of a mesh, with their vertices numbered on their own in the order that they have in the mesh.
struct SomeTets {
  std::vector<std::uint32_t> places;  ///< of the mesh's vertices; kNoOrigin: not of these tets
  std::vector<Tet> tets;
  std::vector<Point> points;
  std::vector<LogMetric> log_metrics;
};

SomeTets some_of(const MetricMeshView& m, const std::vector<std::uint8_t>& wanted) {
  SomeTets some;
  some.places.assign(m.mesh.points.size(), kNoOrigin);
  for (std::size_t t = 0; t < wanted.size(); ++t) {
    if (!wanted[t]) continue;
    some.tets.push_back(m.mesh.tets[t]);
    for (const std::uint32_t v : some.tets.back()) some.places[v] = 0;
  }
  for (std::size_t v = 0; v < some.places.size(); ++v) {
    if (some.places[v] == kNoOrigin) continue;
    some.places[v] = static_cast<std::uint32_t>(some.points.size());
    some.points.push_back(m.mesh.points[v]);
    some.log_metrics.push_back(m.log_metrics[v]);
  }
  for (Tet& tet : some.tets)
    for (std::uint32_t& v : tet) v = some.places[v];
  return some;
}

/// Flags of the edges of these tets: 1 where no other tet of the mesh has the edge.
std::vector<std::uint8_t> edges_alone(const MetricMeshView& m, const std::vector<std::uint8_t>& wanted,
                                      const SomeTets& some, const EdgeLists& edges) {
  std::vector<std::uint8_t> alone(edges.others.size(), 1);
  // Most of the others have no edge of these: bytes are enough to see that.
  std::vector<std::uint8_t> is_known(some.places.size());
  for (std::size_t v = 0; v < is_known.size(); ++v) is_known[v] = some.places[v] != kNoOrigin;
  for (std::size_t t = 0; t < wanted.size(); ++t) {
    const Tet& tet = m.mesh.tets[t];
    if (wanted[t] || is_known[tet[0]] + is_known[tet[1]] + is_known[tet[2]] + is_known[tet[3]] < 2) continue;
    Tet known;
    std::size_t count = 0;
    for (const std::uint32_t v : tet)
      if (some.places[v] != kNoOrigin) known[count++] = some.places[v];
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = i + 1; j < count; ++j) {
        const auto [a, b] = std::minmax(known[i], known[j]);
        const auto others = edges.of(a);
        const auto found = std::ranges::lower_bound(others, b);
        if (found == others.end() || *found != b) continue;
        alone[edges.begins[a] + static_cast<std::size_t>(found - others.begin())] = 0;
      }
  }
  return alone;
}

/// Sums over some tets, and over the edges that they alone have.
struct PartSums {
  TetTotals tets;
  EdgeTotals edges;
  std::vector<double> low, odd;  ///< qualities up to a bound, lengths of edges that are not unit; ascending
};

PartSums sums_over(const MetricMeshView& m, const std::vector<std::uint8_t>& wanted, double bound) {
  PartSums sums;
  const SomeTets some = some_of(m, wanted);
  std::vector<double> qualities;
  const MeasuredPoints points(some.points, some.log_metrics);
  sums.tets = sum_tets(some.tets, points, qualities);
  std::ranges::copy_if(qualities, std::back_inserter(sums.low), [&](double q) { return q <= bound; });
  const EdgeLists edges = unique_edges(some.tets, some.points.size());
  OddLengths odd;
  sums.edges = sum_edges(edges, edges_alone(m, wanted, some, edges), points, &odd);
  sums.odd = std::move(odd.values);
  std::ranges::sort(sums.low);
  std::ranges::sort(sums.odd);
  return sums;
}

void take_off(Histogram& from, const Histogram& h) {
  for (std::size_t i = 0; i < h.counts.size(); ++i) from.counts[i] -= h.counts[i];
  from.below -= h.below;
  from.above -= h.above;
}

/// All but extremes.
TetTotals operator-(TetTotals a, const TetTotals& b) {
  a.volume -= b.volume;
  a.complexity -= b.complexity;
  a.quality -= b.quality;
  a.below_01 -= b.below_01;
  a.below_02 -= b.below_02;
  a.above_08 -= b.above_08;
  take_off(a.linear, b.linear);
  take_off(a.logarithmic, b.logarithmic);
  return a;
}

EdgeTotals operator-(EdgeTotals a, const EdgeTotals& b) {
  a.edges -= b.edges;
  a.unit -= b.unit;
  a.shorter -= b.shorter;
  a.longer -= b.longer;
  a.length -= b.length;
  take_off(a.linear, b.linear);
  take_off(a.logarithmic, b.logarithmic);
  return a;
}

/// Sorted values without some of them and with others.
std::vector<double> exchanged(const std::vector<double>& values, std::span<const double> gone,
                              std::span<const double> come) {
  std::vector<double> rest, all;
  std::ranges::set_difference(values, gone, std::back_inserter(rest));
  std::ranges::merge(rest, come, std::back_inserter(all));
  return all;
}

}  // namespace

MeasuredMesh::MeasuredMesh(const MetricMeshView& m) {
  measures_.num_vertices = m.mesh.points.size();
  measures_.num_tets = m.mesh.tets.size();
  measures_.num_triangles = m.mesh.triangles.size();
  if (m.mesh.tets.empty()) return;
  std::vector<double> qualities;
  const MeasuredPoints points(m.mesh.points, m.log_metrics);
  tets_ = sum_tets(m.mesh.tets, points, qualities);
  put_tets(tets_, measures_.num_tets, measures_);
  const std::size_t q01 = quantile_place(qualities.size(), 0.01);
  const std::size_t kept = std::min(qualities.size(), q01 + q01 / 2 + 16);
  const auto end = qualities.begin() + static_cast<std::ptrdiff_t>(kept);
  std::nth_element(qualities.begin(), end - 1, qualities.end());
  lowest_.assign(qualities.begin(), end);
  std::ranges::sort(lowest_);
  measures_.quality_q01 = lowest_[q01];
  measures_.quality_q001 = lowest_[quantile_place(qualities.size(), 0.001)];
  const EdgeLists edges = unique_edges(m.mesh.tets, m.mesh.points.size());
  constexpr std::size_t kOneIn = 8;
  OddLengths odd;
  odd.most = edges.others.size() / kOneIn;
  edges_ = sum_edges(edges, {}, points, &odd);
  put_edges(edges_, measures_);
  odd_ = std::move(odd.values);
  std::ranges::sort(odd_);
}

std::optional<Measures> MeasuredMesh::of_result(const MetricMeshView& old, const MetricMeshView& result,
                                                std::span<const std::uint32_t> origins) const {
  constexpr double kMost = 0.35;
  if (origins.size() != result.mesh.tets.size() || lowest_.empty() || odd_.empty()) return {};
  std::vector<std::uint8_t> gone(old.mesh.tets.size(), 1), come(origins.size(), 1);
  std::size_t both = 0;
  for (std::size_t t = 0; t < origins.size(); ++t)
    if (origins[t] != kNoOrigin) gone[origins[t]] = come[t] = 0, ++both;
  const auto all = static_cast<double>(old.mesh.tets.size());
  if (all + static_cast<double>(origins.size()) - 2 * static_cast<double>(both) > 2 * kMost * all) return {};

  const PartSums less = sums_over(old, gone, lowest_.back()), more = sums_over(result, come, lowest_.back());
  const std::vector<double> lowest = exchanged(lowest_, less.low, more.low);
  const std::size_t q01 = quantile_place(origins.size(), 0.01);
  const std::vector<double> odd = exchanged(odd_, less.odd, more.odd);
  if (q01 >= lowest.size() || odd.empty() || odd.front() > 1 || odd.back() < 1) return {};

  TetTotals tets = tets_ - less.tets;
  tets += more.tets;
  tets.quality_min = lowest.front();
  EdgeTotals edges = edges_ - less.edges;
  edges += more.edges;
  edges.length_min = odd.front();
  edges.length_max = odd.back();
  Measures m;
  m.num_vertices = result.mesh.points.size();
  m.num_tets = result.mesh.tets.size();
  m.num_triangles = result.mesh.triangles.size();
  put_tets(tets, m.num_tets, m);
  put_edges(edges, m);
  m.quality_q01 = lowest[q01];
  m.quality_q001 = lowest[quantile_place(origins.size(), 0.001)];
  return m;
}

}  // namespace weft::meshing
