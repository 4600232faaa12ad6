// Assembly by rows: every rank sums those of its own vertices.
#include "partition/coordinate/laplace_matrix.h"

#include <algorithm>
#include <array>

#include "meshing/base/parallel.h"
#include "meshing/base/place_in.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::partition {

using meshing::Point;
using meshing::Vec;

namespace {

/// Twice the area vectors of the faces opposite each vertex, towards it: six times the volume times the
/// gradients of the hat functions.
std::array<Vec, 4> scaled_gradients(const meshing::MeshData& mesh, const std::array<std::uint32_t, 4>& tet) {
  std::array<Vec, 4> gradients;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& f = meshing::kTetFaces[i];
    const Point &a = mesh.points[tet[f[0]]], &b = mesh.points[tet[f[1]]], &c = mesh.points[tet[f[2]]];
    gradients[i] = cross(b - a, c - a);
  }
  return gradients;
}

}  // namespace

LaplaceMatrix::LaplaceMatrix(const meshing::MetricDomain& domain)
    : domain_(domain),
      neighbours_(meshing::vertex_neighbours(domain.mesh().tets, domain.mesh().points.size())),
      off_diagonal_(neighbours_.items.size(), 0),
      diagonal_(domain.mesh().points.size(), 0) {
  const meshing::MeshData& mesh = domain.mesh();
  const meshing::VertexLists tets = meshing::vertex_tets(mesh.tets, mesh.points.size());
  meshing::for_each_index(mesh.points.size(), [&](std::size_t v) {
    if (!domain.owns(v)) return;
    const auto row = neighbours_.of(v);
    for (const std::uint32_t t : tets.of(v)) {
      const auto& tet = mesh.tets[t];
      const double six =
          six_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
      if (!(six > 0)) continue;
      const std::array<Vec, 4> gradients = scaled_gradients(mesh, tet);
      const auto mine = static_cast<std::size_t>(std::ranges::find(tet, v) - tet.begin());
      for (std::size_t i = 0; i < 4; ++i) {
        const double entry = dot(gradients[mine], gradients[i]) / (6 * six);
        if (i == mine) {
          diagonal_[v] += entry;
          continue;
        }
        off_diagonal_[neighbours_.begins[v] + meshing::place_in(row, tet[i])] += entry;
      }
    }
  });
}

void LaplaceMatrix::multiply(std::span<const double> x, std::span<double> y) const {
  meshing::for_each_index(diagonal_.size(), [&](std::size_t v) {
    if (!domain_.owns(v)) return;
    double sum = diagonal_[v] * x[v];
    const auto row = neighbours_.of(v);
    for (std::size_t i = 0; i < row.size(); ++i) sum += off_diagonal_[neighbours_.begins[v] + i] * x[row[i]];
    y[v] = sum;
  });
}

}  // namespace weft::partition
