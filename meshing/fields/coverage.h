// How far a mesh lies outside the one that it reads values from.
#pragma once

#include <cstdint>

#include "meshing/fields/mesh_pair.h"
#include "meshing/fields/reading.h"

namespace weft::meshing {

struct Uncovered {
  std::uint64_t vertices = 0;
  double farthest = 0;  ///< largest distance of one of them from the old mesh
};

/// The vertices of the new mesh that lie outside the old one by more than a tenth of the size of the tet
/// there: by more than rounding, and than chords of a curved boundary do. `reading`: of this pair, with its
/// source as it is. All parts call together, and hear the same.
Uncovered uncovered(const MeshPair& meshes, const Reading& reading);
/// The same of whole meshes. Multithreaded on TBB; 1 us a vertex of `to`, and 66 bytes a tet of `from`
/// meanwhile. Throws InputError naming the tet of `from` (1-based) that has no volume or is inverted, and for
/// a `from` without tets.
Uncovered uncovered(const MeshData& from, const MeshData& to);

}  // namespace weft::meshing
