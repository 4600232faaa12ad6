// Branch and bound over a tree of the surface's vertices: near and small ones first.
#include "meshing/initial/point_distribution.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::meshing {

PointDistribution::PointDistribution(const MeshData& mesh, double growth, double size)
    : slope_(growth - 1), size_(size > 0 ? size : std::numeric_limits<double>::infinity()) {
  std::vector<double> sum(mesh.points.size());
  std::vector<std::uint32_t> count(mesh.points.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      const double length = norm(mesh.points[b] - mesh.points[a]);
      sum[a] += length, sum[b] += length;
      ++count[a], ++count[b];
    }
  for (std::size_t v = 0; v < sum.size(); ++v)
    if (count[v] > 0) sources_.push_back({mesh.points[v], sum[v] / count[v], static_cast<std::uint32_t>(v)});
  std::size_t leaves = 1;
  while (leaves * kLeaf < sources_.size()) leaves *= 2;
  nodes_.resize(2 * leaves + 2);
  build(1, 0, sources_.size());
}

void PointDistribution::build(std::size_t node, std::size_t begin, std::size_t end) {
  Node& n = nodes_[node];
  n.least_size = std::numeric_limits<double>::infinity();
  n.largest_size = 0;
  for (std::size_t i = begin; i < end; ++i) {
    n.box.include(sources_[i].at);
    n.least_size = std::min(n.least_size, sources_[i].size);
    n.largest_size = std::max(n.largest_size, sources_[i].size);
  }
  if (end - begin <= kLeaf) return;
  const Vec extent = n.box.size();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return sources_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const Source& a, const Source& b) { return a.at[axis] < b.at[axis]; });
  build(2 * node, begin, middle);
  build(2 * node + 1, middle, end);
}

double PointDistribution::steepest(const Source& from) const {
  constexpr double kSteepest = 0.6;  // tets beside steeper sizes are poor: 0.8 and 1 lost Q mean, 0.4 points
  double slope = slope_;
  search_steepest(1, 0, sources_.size(), from, slope);
  return std::max(slope_, std::min(slope, kSteepest));
}

/// What is nearer than one edge counts as one edge away: stretched triangles have ends of tiny edges whose
/// mean lengths differ, and nothing grows there.
void PointDistribution::search_steepest(std::size_t node, std::size_t begin, std::size_t end,
                                        const Source& from, double& best) const {
  const auto far = [&](double distance) { return std::max(distance, from.size); };
  const Node& n = nodes_[node];
  if (n.largest_size - from.size <= best * far(std::sqrt(n.box.distance2(from.at)))) return;
  if (end - begin <= kLeaf) {
    for (std::size_t i = begin; i < end; ++i)
      best = std::max(best, (sources_[i].size - from.size) / far(norm(sources_[i].at - from.at)));
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  search_steepest(2 * node, begin, middle, from, best);
  search_steepest(2 * node + 1, middle, end, from, best);
}

double PointDistribution::bound(std::size_t node, const Point& p) const {
  return nodes_[node].least_size + slope_ * std::sqrt(nodes_[node].box.distance2(p));
}

void PointDistribution::search(std::size_t node, std::size_t begin, std::size_t end, const Point& p,
                               double& best) const {
  if (bound(node, p) >= best) return;
  if (end - begin <= kLeaf) {
    for (std::size_t i = begin; i < end; ++i)
      best = std::min(best, sources_[i].size + slope_ * norm(p - sources_[i].at));
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const bool left_first = bound(2 * node, p) <= bound(2 * node + 1, p);
  if (left_first) search(2 * node, begin, middle, p, best);
  search(2 * node + 1, middle, end, p, best);
  if (!left_first) search(2 * node, begin, middle, p, best);
}

double PointDistribution::operator()(const Point& p) const {
  double best = size_;
  search(1, 0, sources_.size(), p, best);
  return best;
}

LogMetricField PointDistribution::sample(std::span<const Point> points, double factor) const {
  LogMetricField field(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    field[i] = identity_tensor(-2 * std::log(factor * (*this)(points[i])));
  });
  return field;
}

std::vector<SizeSource> PointDistribution::size_sources() const {
  std::vector<SizeSource> given(sources_.size());
  tbb::parallel_for(std::size_t{0}, sources_.size(), [&](std::size_t i) {
    given[i] = {sources_[i].vertex, sources_[i].size, steepest(sources_[i])};
  });
  return given;
}

}  // namespace weft::meshing
