// The boundary and the material interfaces of the whole mesh, checked against the tets and completed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/distribute/mesh_slice.h"

namespace weft::partition {

/// Every rank has all of it.
struct WholeBoundary {
  meshing::MeshData data;  ///< numbered by entries of `numbers`; no tets and no references of points
  std::vector<std::uint32_t> numbers;  ///< of data.points in the whole input, ascending
  std::vector<std::string> warnings;   ///< what was repaired, in the words of meshing::import_mesh
};

/// Matches the faces of all tets, in the slice (`placed`: its tets), 50 bytes a tet of temporaries; where the
/// other side, a third tet or a triangle may be elsewhere, at a rank that the lowest vertex decides. Every
/// rank throws the same InputError, in the words of meshing::import_mesh, for a face of three tets, tets on
/// the same side of a face, and a triangle that is no face. Drops repeated triangles and edges that lie on no
/// triangle, and creates triangles of reference 0 where boundary or interface has none. Numbers, patches and
/// curves of the result are those that meshing::import_mesh makes of the whole mesh. The slices must have
/// passed check_slices. All ranks call together.
WholeBoundary complete_boundary(Peers& peers, const MeshSlice& slice, const PlacedTets& placed,
                                const Ranges& points, const Ranges& tets);

}  // namespace weft::partition
