// Polygons in space as triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Of all triangulations of a loop of vertices that with the least area (Barequet and Sharir, 1995); of a
/// plane polygon one that does not fold over. Triangles run as the loop does. Takes n^3 steps for n >= 3
/// vertices.
std::vector<Triangle> triangulate_loop(std::span<const Point> points, std::span<const std::uint32_t> loop);

/// Faces of more than three corners that a file has. They become fans around their first corner, and once
/// all points are known, those whose fan folds over are cut anew.
class Polygons {
 public:
  /// Appends the fan of at least three corners to the triangles.
  void add(std::span<const std::uint32_t> corners, std::int32_t ref, MeshData& mesh);
  /// All vertices of the triangles must be points of the mesh.
  void unfold(MeshData& mesh) const;

 private:
  struct Fan {
    std::size_t first, size;  ///< its triangles
  };
  std::vector<Fan> fans_;
};

}  // namespace weft::meshing
