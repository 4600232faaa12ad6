// A coordinate that follows the boundary, at the vertices of a mesh that ranks have in shares.
#pragma once

#include <string>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/decompose/coordinate_name.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// Of a coordinate: its values, and what is to be said of them.
struct CoordinateValues {
  std::vector<double> values;  ///< at slice.points; finite, at points of no tet any
  std::string warning = {};    ///< the same on all ranks
};

/// The coordinate at this rank's slice of points; all ranks call together. The same bits for any number of
/// ranks and any shares.
///
/// Harmonic: linear finite elements, 0 on the triangles of the first reference, 1 on those of the second, 1/2
/// where they meet; no flux through the rest of the boundary. Conjugate gradients to 1e-6 of the first
/// residual; a warning where 3,000 steps are not enough. Wall: the Euclidean distance from the nearest
/// triangle of the references, also through what is not meshed.
///
/// Throws meshing::InputError, the same on all ranks: for a reference that no triangle has; harmonic, for
/// points of tets that no chain of tets joins to both references; what PartDomain throws.
CoordinateValues boundary_coordinate(Peers& peers, const MeshSlice& slice,
                                     const BoundaryCoordinate& coordinate);

}  // namespace weft::partition
