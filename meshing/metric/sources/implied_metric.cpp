// Metrics of single tets and their means at vertices.
#include "meshing/metric/sources/implied_metric.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/predicates.h"

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

bool is_finite(const LogMetric& l) { return std::isfinite(l.xx + l.xy + l.yy + l.xz + l.yz + l.zz); }

/// Vertices that have nothing but flat tets take the mean of those of their neighbours that have a metric.
void fill_from_neighbours(const MeshData& mesh, const VertexLists& tets_at, std::vector<std::uint8_t>& found,
                          LogMetricField& field) {
  for (std::size_t vertex = 0; vertex < field.size(); ++vertex) {
    if (found[vertex]) continue;
    LogMetric sum;
    double count = 0;
    for (const std::uint32_t t : tets_at.of(vertex))
      for (const std::uint32_t v : mesh.tets[t]) {
        if (!found[v]) continue;
        sum = sum + field[v];
        ++count;
      }
    if (count > 0) field[vertex] = (1 / count) * sum;
  }
}

}  // namespace

LogMetricField implied_metric(const MeshData& mesh) { return implied_metric(WholeDomain(mesh)); }

LogMetricField implied_metric(const MetricDomain& domain) {
  const MeshData& mesh = domain.mesh();
  const VertexLists tets_at = vertex_tets(mesh.tets, mesh.points.size());
  const auto& p = mesh.points;
  const std::size_t bad = find_first(mesh.tets.size(), [&](std::size_t t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    return orientation(p[a], p[b], p[c], p[d]) <= 0;
  });
  if (bad < mesh.tets.size())
    throw InputError("", "tet " + std::to_string(bad + 1), "has no volume or is inverted, so no metric");
  LogMetricField field(p.size(), identity_tensor(-2 * std::log(domain.largest_size())));
  std::vector<std::uint8_t> found(p.size(), 0);
  for_each_index(field.size(), [&](std::size_t vertex) {
    LogMetric sum;
    double weight = 0;
    for (const std::uint32_t t : tets_at.of(vertex)) {
      const auto& [a, b, c, d] = mesh.tets[t];
      const double volume = six_volume(p[a], p[b], p[c], p[d]);
      if (!(volume > 0)) continue;
      const LogMetric of_tet = log_metric_of_tet(p[b] - p[a], p[c] - p[a], p[d] - p[a], volume);
      if (!is_finite(of_tet)) continue;  // too flat for doubles
      sum = sum + volume * of_tet;
      weight += volume;
    }
    if (!(weight > 0)) return;
    field[vertex] = (1 / weight) * sum;
    found[vertex] = 1;
  });
  domain.refresh(field);
  domain.refresh(found);
  fill_from_neighbours(mesh, tets_at, found, field);
  domain.refresh(field);
  return field;
}

}  // namespace weft::meshing
