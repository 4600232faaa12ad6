// Metrics of single tets and their means at vertices.
#include "meshing/metric/implied_metric.h"

#include <array>
#include <cmath>
#include <string>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/metric/boundary_metric.h"

namespace weft::meshing {
namespace {

/// The rows of F^-1, F the affine map from the regular tet of edge 1 to the tet with edges u, v, w from its
/// first corner; their Gram matrix is the metric F^-T F^-1.
LogMetric log_metric_of_tet(const Vec& u, const Vec& v, const Vec& w, double six_volumes) {
  // Gradients of the last three barycentric coordinates: the rows of (u v w)^-1.
  const double s = 1 / six_volumes;
  const Vec gu = s * cross(v, w), gv = s * cross(w, u), gw = s * cross(u, v);
  // Every edge gradient product counts: M = sum over i, j of G_ij g_i g_j^T, G the Gram matrix of the regular
  // tet's edges, 1 on and 1/2 off the diagonal.
  const auto product = [&](auto x, auto y) {
    const double ux = x(gu), vx = x(gv), wx = x(gw), uy = y(gu), vy = y(gv), wy = y(gw);
    return ux * uy + vx * vy + wx * wy + 0.5 * (ux * vy + vx * uy + ux * wy + wx * uy + vx * wy + wx * vy);
  };
  const auto x = [](const Vec& g) { return g.x; };
  const auto y = [](const Vec& g) { return g.y; };
  const auto z = [](const Vec& g) { return g.z; };
  return log_of({product(x, x), product(x, y), product(y, y), product(x, z), product(y, z), product(z, z)});
}

}  // namespace

LogMetricField implied_metric(const MeshData& mesh) {
  const VertexLists tets_at = vertex_tets(mesh.tets, mesh.points.size());
  const auto& p = mesh.points;
  const auto six_volumes = [&](std::size_t t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    return six_volume(p[a], p[b], p[c], p[d]);
  };
  const std::size_t flat = find_first(mesh.tets.size(), [&](std::size_t t) { return !(six_volumes(t) > 0); });
  if (flat < mesh.tets.size())
    throw InputError("", "tet " + std::to_string(flat + 1), "has no volume or is inverted, so no metric");
  LogMetricField field(p.size(), identity_tensor(-2 * std::log(largest_size(mesh))));
  for_each_index(field.size(), [&](std::size_t vertex) {
    if (tets_at.of(vertex).empty()) return;
    LogMetric sum;
    double weight = 0;
    for (const std::uint32_t t : tets_at.of(vertex)) {
      const auto& [a, b, c, d] = mesh.tets[t];
      const double volume = six_volumes(t);
      sum = sum + volume * log_metric_of_tet(p[b] - p[a], p[c] - p[a], p[d] - p[a], volume);
      weight += volume;
    }
    field[vertex] = (1 / weight) * sum;
  });
  return field;
}

}  // namespace weft::meshing
