#include "meshing/fields/coverage.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {
namespace {

double longest_edge2(const MeshData& mesh, const Tet& tet) {
  double longest = 0;
  for (const auto& edge : kTetEdges) {
    const std::uint32_t a = tet[static_cast<std::size_t>(edge[0])],
                        b = tet[static_cast<std::size_t>(edge[1])];
    longest = std::max(longest, norm2(mesh.points[b] - mesh.points[a]));
  }
  return longest;
}

}  // namespace

Uncovered uncovered(const MeshPair& meshes, const Reading& reading) {
  constexpr double kShareOfSize = 0.1;
  const MetricDomain& to = meshes.new_mesh();
  const MeshData& source = meshes.source();
  const auto lies_outside = [&](std::size_t v) {
    const double distance = reading.at.distances[v];
    if (!(distance > 0)) return false;
    const Tet& tet = source.tets[reading.at.places[v]];
    return distance * distance > kShareOfSize * kShareOfSize * longest_edge2(source, tet);
  };
  double farthest = 0;
  for (std::size_t v = 0; v < reading.at.distances.size(); ++v)
    if (to.owns(v) && lies_outside(v)) farthest = std::max(farthest, reading.at.distances[v]);
  Uncovered found;
  found.farthest = to.max(farthest);
  found.vertices = static_cast<std::uint64_t>(
      std::llround(to.sum([&](std::size_t v) { return lies_outside(v) ? 1.0 : 0.0; })));
  return found;
}

Uncovered uncovered(const MeshData& from, const MeshData& to) {
  WholePair meshes(from, to);
  return uncovered(meshes, read(meshes, {}));
}

}  // namespace weft::meshing
