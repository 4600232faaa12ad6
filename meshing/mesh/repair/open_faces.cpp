// By sorting faces and triangles.
#include "meshing/mesh/repair/open_faces.h"

#include <tbb/parallel_sort.h>

#include <algorithm>

#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {

std::vector<OpenFace> sorted_faces(const MeshData& mesh) {
  std::vector<OpenFace> faces;
  faces.reserve(4 * mesh.tets.size());
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
    for (std::uint32_t f = 0; f < 4; ++f) {
      OpenFace face{{}, 4 * t + f};
      for (std::size_t i = 0; i < 3; ++i) face.vertices[i] = mesh.tets[t][kTetFaces[f][i]];
      std::sort(face.vertices.begin(), face.vertices.end());
      faces.push_back(face);
    }
  tbb::parallel_sort(faces);
  return faces;
}

std::vector<OpenFace> open_faces(const MeshData& mesh) {
  std::vector<Triangle> listed(mesh.triangles);
  for (Triangle& t : listed) std::sort(t.begin(), t.end());
  std::sort(listed.begin(), listed.end());
  const std::vector<OpenFace> all = sorted_faces(mesh);
  std::vector<OpenFace> open;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool shared = (i > 0 && all[i - 1].vertices == all[i].vertices) ||
                        (i + 1 < all.size() && all[i + 1].vertices == all[i].vertices);
    if (!shared && !std::binary_search(listed.begin(), listed.end(), all[i].vertices)) open.push_back(all[i]);
  }
  return open;
}

}  // namespace weft::meshing
