// An order of vertices by their places in the metric, and of the tets that follow it.
#include "meshing/kernel/renumber.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace weft::meshing {
namespace {

/// A vertex on its way to its place in the order.
struct Item {
  Point x;
  std::uint32_t vertex;
  double key;
};

/// Some of a range's vertices stand for all.
struct Sample {
  static constexpr std::size_t kSize = 48;

  Sample(const TetMesh& mesh, std::span<const Item> items) {
    const std::size_t step = std::max<std::size_t>(1, items.size() / kSize);
    std::size_t count = 0;
    for (std::size_t i = 0; i < items.size(); i += step, ++count) {
      mean += items[i].x - items[0].x;
      log_metric = log_metric + mesh.log_metric(VertexId(items[i].vertex));
    }
    const double share = 1 / static_cast<double>(count);
    mean = items[0].x + share * mean;
    log_metric = share * log_metric;
    for (std::size_t i = 0; i < items.size(); i += step) {
      const Vec d = items[i].x - mean;
      spread = spread + SymTensor{d.x * d.x, d.x * d.y, d.y * d.y, d.x * d.z, d.y * d.z, d.z * d.z};
    }
  }

  /// The gradient of the linear function by which the range is longest in its metric.
  Vec longest() const {
    constexpr int kIterations = 6;
    const Metric metric = exp_fast(log_metric);
    Vec direction{1, 0.8, 0.6}, gradient = direction;
    for (int i = 0; i < kIterations; ++i) {
      gradient = apply(metric, direction);
      const Vec next = apply(spread, gradient);
      const double size = norm(next);
      if (!(size > 0 && std::isfinite(size))) break;
      direction = (1 / size) * next;
    }
    return gradient;
  }

  Point mean;
  LogMetric log_metric;
  SymTensor spread;
};

/// Halves a range across the direction in which it is longest in the metric, and so on: what a stretch of the
/// order holds is as near to a ball in the metric as can be, and has few neighbours elsewhere.
void order_by_halves(const TetMesh& mesh, std::span<Item> items) {
  constexpr std::size_t kFew = 16, kManyForOneTask = 8192;
  if (items.size() < 2) return;
  const Sample sample(mesh, items);
  const Vec along = sample.longest();
  for (Item& i : items) i.key = dot(along, i.x - sample.mean);
  const auto before = [](const Item& a, const Item& b) {
    return a.key != b.key ? a.key < b.key : a.vertex < b.vertex;
  };
  if (items.size() <= kFew) return std::sort(items.begin(), items.end(), before);
  const std::size_t half = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(), before);
  const auto first = [&] { order_by_halves(mesh, items.first(half)); };
  const auto second = [&] { order_by_halves(mesh, items.subspan(half)); };
  if (items.size() > kManyForOneTask) return tbb::parallel_invoke(first, second);
  first();
  second();
}

std::vector<VertexId> vertex_order(const TetMesh& mesh, std::uint32_t& count) {
  std::vector<Item> items;
  items.reserve(mesh.vertex_slots());
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i))) items.push_back({mesh.point(VertexId(i)), i, 0});
  order_by_halves(mesh, items);
  count = static_cast<std::uint32_t>(items.size());
  std::vector<VertexId> new_vertex(mesh.vertex_slots());
  for (std::uint32_t i = 0; i < count; ++i) new_vertex[items[i].vertex] = VertexId(i);
  return new_vertex;
}

/// Counting sort of the live tets by their smallest new vertex.
std::vector<TetId> tet_order(const TetMesh& mesh, const std::vector<VertexId>& new_vertex,
                             std::uint32_t num_vertices, std::uint32_t& count) {
  std::vector<std::uint32_t> begin(num_vertices + 1, 0);
  std::vector<std::uint32_t> first(mesh.tet_slots());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    if (!mesh.alive(TetId(i))) continue;
    const TetVertices v = mesh.vertices(TetId(i));
    first[i] = std::min({new_vertex[v[0].value], new_vertex[v[1].value], new_vertex[v[2].value],
                         new_vertex[v[3].value]})
                   .value;
    ++begin[first[i] + 1];
  }
  for (std::uint32_t v = 0; v < num_vertices; ++v) begin[v + 1] += begin[v];
  count = begin[num_vertices];
  std::vector<TetId> new_tet(mesh.tet_slots());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (mesh.alive(TetId(i))) new_tet[i] = TetId(begin[first[i]]++);
  return new_tet;
}

bool have_common_vertex(const TetVertices& a, const TetVertices& b) {
  bool common = false;  // without a branch: any of the sixteen may be
  for (const VertexId v : a)
    for (const VertexId w : b) common |= v == w;
  return common;
}

}  // namespace

void renumber_along_curve(TetMesh& mesh) {
  std::uint32_t num_vertices = 0, num_tets = 0;
  const std::vector<VertexId> new_vertex = vertex_order(mesh, num_vertices);
  const std::vector<TetId> new_tet = tet_order(mesh, new_vertex, num_vertices, num_tets);
  mesh.renumber(new_vertex, num_vertices, new_tet, num_tets);
}

bool is_in_order(const TetMesh& mesh) {
  constexpr double kMostApart = 0.2, kMostFar = 0.3;
  constexpr std::uint32_t kNear = 2048;
  const std::uint32_t far = std::max(mesh.vertex_slots() / 8, kNear);
  std::uint64_t tets = 0, apart = 0, spread = 0;
  TetVertices last;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    if (!mesh.alive(TetId(i))) continue;
    const TetVertices v = mesh.vertices(TetId(i));
    const auto [first, end] = std::minmax({v[0], v[1], v[2], v[3]});
    ++tets;
    apart += !have_common_vertex(v, last);
    spread += end.value - first.value > far;
    last = v;
  }
  const auto all = static_cast<double>(tets);
  return static_cast<double>(apart) <= kMostApart * all && static_cast<double>(spread) <= kMostFar * all;
}

}  // namespace weft::meshing
