// The boundary and the material interfaces of the whole mesh, checked against the tets and completed, in
// shares.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "meshing/base/point.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/slice/mesh_slice.h"
#include "partition/surface/listed_points.h"

namespace weft::partition {

/// A triangle of the completed boundary; vertices are numbered as in the whole input.
struct BoundaryTriangle {
  std::uint32_t number;  ///< among all, as meshing::import_mesh numbers them
  std::array<std::uint32_t, 3> vertices;
  std::int32_t ref;
  std::uint32_t required;  ///< 0 or 1
};

/// An edge that the input lists, or at which the mesh touches itself.
struct BoundaryEdge {
  std::array<std::uint32_t, 2> vertices;  ///< ascending
  std::int32_t ref;
  std::uint32_t required;
};

struct BoundaryShare {
  std::vector<BoundaryTriangle> triangles;  ///< each on one rank
  std::vector<BoundaryEdge> edges;          ///< each once, where its lower vertex modulo the ranks says
  std::vector<ListedPoint> listed_points;   ///< likewise, ascending
  bool any_listed_points = true;            ///< false, on all ranks: none has any
  meshing::Association on_model;            ///< the slice's records of vertices, without a model
  std::vector<std::string> warnings;        ///< what was repaired, in the words of meshing::import_mesh
};

/// All ranks: the points of these numbers, ascending.
using FetchPoints = std::function<std::vector<meshing::Point>(const std::vector<std::uint32_t>&)>;

/// Matches the faces of all tets, in the slice (`placed`: its tets), 50 bytes a tet of temporaries; where the
/// other side, a third tet or a triangle may be elsewhere, at a rank that the lowest vertex decides. Every
/// rank throws the same InputError, in the words of meshing::import_mesh, for a face of three tets, tets on
/// the same side of a face, and a triangle that is no face. Drops repeated triangles and edges that lie on no
/// triangle, and creates triangles of reference 0 where boundary or interface has none. The slices must have
/// passed check_slices. Gives the slice's boundary back. All ranks call together.
BoundaryShare complete_boundary(Peers& peers, MeshSlice& slice, const PlacedTets& placed,
                                const Ranges& points, const Ranges& tets);

/// All ranks: the boundary as it is listed, not compared with the tets: edges that lie on no triangle are
/// left out alone. Every rank throws the same InputError for a triangle that has a vertex twice.
BoundaryShare listed_boundary(Peers& peers, const MeshSlice& slice);

}  // namespace weft::partition
