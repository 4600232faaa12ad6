// One walk through the mesh, along the tets of the background.
#include "partition/divide/pieces_of_parts.h"

#include <algorithm>

#include "meshing/fields/tet_locator.h"

namespace weft::partition {

std::vector<std::vector<std::uint64_t>> pieces_of_parts(const Subdomain& s,
                                                        std::span<const std::array<std::uint32_t, 4>> tets,
                                                        std::span<const SubdomainId> parts,
                                                        std::uint32_t num_parts) {
  meshing::MeshData mesh;
  mesh.tets.assign(tets.begin(), tets.end());
  mesh.points.resize(s.mesh->vertex_slots());
  for (std::uint32_t i = 0; i < mesh.points.size(); ++i)
    if (const meshing::VertexId v(i); s.mesh->alive(v)) mesh.points[i] = s.mesh->point(v);
  const meshing::TetLocator locator(mesh, meshing::build_adjacency(mesh.tets, mesh.points.size()));
  std::vector<std::vector<std::uint64_t>> pieces(num_parts);
  std::uint32_t last = 0;
  for (const BackgroundStore::SharedPiece& piece : s.background.all_pieces())
    for (const auto& [a, b, c, d] : piece->tets) {
      const auto& x = piece->points;
      last = locator.locate(0.25 * (x[a] + x[b] + x[c] + x[d]), last).tet;
      std::vector<std::uint64_t>& of_part = pieces[parts[last].value];
      if (of_part.empty() || of_part.back() != piece->id) of_part.push_back(piece->id);
    }
  for (std::vector<std::uint64_t>& of_part : pieces) std::ranges::sort(of_part);
  return pieces;
}

}  // namespace weft::partition
