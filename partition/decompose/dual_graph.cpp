// Faces meet by sorting.
#include "partition/decompose/dual_graph.h"

#include <algorithm>
#include <tuple>

#include "meshing/mesh/tet_tables.h"
#include "partition/decompose/tet_measures.h"

namespace weft::partition {
namespace {

struct Face {
  std::array<std::uint32_t, 3> vertices;  // ascending
  std::uint32_t tet;
  float area;
};

std::vector<Face> sorted_faces(std::span<const DualVertex> tets) {
  std::vector<Face> faces;
  faces.reserve(4 * tets.size());
  for (std::uint32_t t = 0; t < tets.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i) {
      const auto& f = meshing::kTetFaces[i];
      const auto& v = tets[t].vertices;
      faces.push_back({{v[f[0]], v[f[1]], v[f[2]]}, t, tets[t].face_areas[i]});
      std::sort(faces.back().vertices.begin(), faces.back().vertices.end());
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return std::tie(a.vertices, a.tet) < std::tie(b.vertices, b.tet);
  });
  return faces;
}

}  // namespace

DualGraph dual_graph(std::span<const DualVertex> tets) {
  const std::vector<Face> faces = sorted_faces(tets);
  const auto for_each_shared = [&](const auto& action) {
    for (std::size_t i = 0; i + 1 < faces.size(); ++i)
      if (faces[i].vertices == faces[i + 1].vertices) {
        action(faces[i], faces[i + 1]);
        while (i + 1 < faces.size() && faces[i].vertices == faces[i + 1].vertices) ++i;
      }
  };
  DualGraph g;
  g.begins.assign(tets.size() + 1, 0);
  for_each_shared([&](const Face& a, const Face& b) { ++g.begins[a.tet + 1], ++g.begins[b.tet + 1]; });
  for (std::size_t t = 0; t < tets.size(); ++t) g.begins[t + 1] += g.begins[t];
  g.neighbours.resize(static_cast<std::size_t>(g.begins.back()));
  g.face_weights.resize(g.neighbours.size());
  std::vector<std::int32_t> next(g.begins.begin(), g.begins.end() - 1);
  for_each_shared([&](const Face& a, const Face& b) {
    const double weight = 0.5 + vertices_wanted(a.area, b.area);
    const auto add = [&](std::uint32_t from, std::uint32_t to) {
      const auto at = static_cast<std::size_t>(next[from]++);
      g.neighbours[at] = static_cast<std::int32_t>(to);
      g.face_weights[at] = weight;
    };
    add(a.tet, b.tet);
    add(b.tet, a.tet);
  });
  return g;
}

}  // namespace weft::partition
