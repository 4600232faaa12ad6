// A mesh as a grid for a while.
#pragma once

#include "meshing/initial/grid/tet_grid.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// The grid that a mesh's tets are, with its triangles for facets, and the mesh again.
class GridOfMesh {
 public:
  explicit GridOfMesh(MeshData mesh);

  TetGrid grid;

  /// The points that tets hold, which are the mesh's in this order.
  std::vector<std::uint32_t> points_of_tets() const;
  /// The mesh with the tets that the grid has by now; they have the references of the volumes they are in.
  /// New points stand behind the others, those that no tet holds are gone. Triangles and lists are as they
  /// were.
  MeshData take();

 private:
  std::int32_t& ref_beside(std::uint32_t facet, const Face3& face);
  std::vector<std::uint32_t> close_points();

  MeshData mesh_;
  std::vector<std::int32_t> refs_;  ///< of the volumes on both sides of every facet
};

}  // namespace weft::meshing
