// Which triangles of a mesh a picture shows: its surface, and what a cut lays bare.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"
#include "tools/picture/facet.h"

namespace weft::picture {

/// A triangle of the surface or a face of a tet.
struct ShownFace {
  std::array<std::uint32_t, 3> vertices;
  std::uint32_t tet =
      meshing::kNoNeighbour;        ///< the one it belongs to, on the shown side; none in a mesh without
  std::optional<std::int32_t> ref;  ///< of triangles
  bool inside = false;              ///< laid bare by the cut
};

/// The surface of a mesh: its triangles, and the faces of single tets that no triangle covers.
class Surface {
 public:
  /// With `only`, just the triangles of these references. Throws InputError (no file name) for indices out of
  /// range and for faces of more than two tets. `mesh` must outlive the object. Memory: 16 bytes a tet,
  /// 50 more for a moment.
  explicit Surface(const meshing::MeshData& mesh, const std::optional<std::vector<std::int32_t>>& only = {});

  const std::vector<ShownFace>& faces() const& { return faces_; }
  std::vector<ShownFace> faces() && { return std::move(faces_); }

  /// The faces of what is left without the tets (and, where there are none, triangles) whose centroids lie in
  /// front of the plane.
  std::vector<ShownFace> behind(const Plane& plane) const;

 private:
  void add_uncovered();

  const meshing::MeshData& mesh_;
  meshing::Adjacency adjacency_;
  std::vector<ShownFace> faces_;
  std::vector<std::uint32_t> codes_;  ///< of each of faces_: tet * 4 + face, kNoNeighbour without a tet
  std::vector<bool> covered_;         ///< by code: tet faces that faces_ has as triangles
};

/// The plane section of a tet, a triangle or, with four corners, a quadrilateral.
struct Section {
  /// A corner: the point at `share` of the way from vertex `from` to vertex `to`.
  struct Corner {
    std::uint32_t from, to;
    double share;
  };
  std::uint32_t tet;
  int size;
  std::array<Corner, 4> corners;  ///< in cyclic order
};

/// The section of one tet; none where no vertex lies in front of the plane, or all do.
std::optional<Section> section(const meshing::MeshData& mesh, std::uint32_t tet, const Plane& plane);

/// The sections of all tets that have vertices both in front of the plane and not. Together they cover the
/// section of the mesh once, also where the plane contains faces.
std::vector<Section> sections(const meshing::MeshData& mesh, const Plane& plane);

}  // namespace weft::picture
