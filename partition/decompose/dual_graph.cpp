// Tets meet at their faces; each has its neighbours in the order of its faces' vertices.
#include "partition/decompose/dual_graph.h"

#include <algorithm>

#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/decompose/tet_measures.h"

namespace weft::partition {
namespace {

using meshing::Tet;

std::vector<Tet> neighbours_of(std::span<const DualVertex> tets) {
  std::vector<std::uint32_t> numbers = distinct_vertices(
      tets, [](const DualVertex& tet) -> const auto& { return tet.vertices; });
  PlacesOfNumbers places(numbers);
  std::vector<Tet> placed;
  placed.reserve(tets.size());
  for (const DualVertex& tet : tets) placed.push_back(places(tet.vertices));
  return std::move(meshing::build_adjacency(placed, numbers.size()).neighbours);
}

/// The faces of a tet in the order of their vertices: that of the vertices opposite them, turned round.
std::array<std::size_t, 4> faces_in_order(const Tet& vertices) {
  std::array<std::size_t, 4> faces{0, 1, 2, 3};
  std::ranges::sort(faces, [&](std::size_t a, std::size_t b) { return vertices[a] > vertices[b]; });
  return faces;
}

}  // namespace

DualGraph dual_graph(std::span<const DualVertex> tets) {
  const std::vector<Tet> neighbours = neighbours_of(tets);
  DualGraph g;
  g.begins.reserve(tets.size() + 1);
  g.begins.push_back(0);
  g.neighbours.reserve(4 * tets.size());
  g.face_weights.reserve(4 * tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (const std::size_t f : faces_in_order(tets[t].vertices)) {
      const std::uint32_t code = neighbours[t][f];
      if (code == meshing::kNoNeighbour) continue;
      g.neighbours.push_back(static_cast<std::int32_t>(code >> 2));
      g.face_weights.push_back(0.5 +
                               vertices_wanted(tets[t].face_areas[f], tets[code >> 2].face_areas[code & 3]));
    }
    g.begins.push_back(static_cast<std::int32_t>(g.neighbours.size()));
  }
  return g;
}

}  // namespace weft::partition
