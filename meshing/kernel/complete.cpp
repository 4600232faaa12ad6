// What import_mesh() would complete, looked for by cheaper means.
#include "meshing/kernel/complete.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <utility>

#include "meshing/geometry/surface/face_directions.h"
#include "meshing/mesh/face_sums.h"

namespace weft::meshing {
namespace {

using Ends = std::array<std::uint32_t, 2>;

Ends ends_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

bool uses_all_points(const MeshData& mesh) {
  std::vector<std::uint8_t> used(mesh.points.size(), 0);
  for (const Tet& tet : mesh.tets)
    for (const std::uint32_t v : tet) used[v] = 1;
  return std::ranges::find(used, 0) == used.end();
}

}  // namespace

bool edges_are_complete(std::vector<TriangleSide> sides, std::vector<Ends> edges) {
  tbb::parallel_sort(sides.begin(), sides.end());
  std::ranges::sort(edges);
  if (std::ranges::adjacent_find(edges) != edges.end()) return false;
  auto edge = edges.begin();
  for (auto side = sides.begin(); side != sides.end();) {
    std::uint32_t outer = 0;
    const Ends vertices = side->vertices;
    for (; side != sides.end() && side->vertices == vertices; ++side) outer += side->outer;
    if (outer > 2 || (edge != edges.end() && *edge < vertices)) return false;
    if (edge != edges.end() && *edge == vertices) ++edge;
  }
  return edge == edges.end();
}

bool is_complete(const MeshData& mesh) {
  if (!mesh.association.empty() || !uses_all_points(mesh)) return false;
  std::vector<std::uint8_t> outer;
  if (!sum_faces(mesh, {}, &outer).ok()) return false;
  std::vector<TriangleSide> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      sides.push_back({ends_of(mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]), outer[t]});
  std::vector<Ends> edges;
  for (const auto& [a, b] : mesh.edges) edges.push_back(ends_of(a, b));
  if (!edges_are_complete(std::move(sides), std::move(edges))) return false;
  return !may_curve(mesh) || crowded_sides(mesh) == 0;
}

}  // namespace weft::meshing
