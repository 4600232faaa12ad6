// Holes between parts: faces that should have met another tet, or a triangle.
#pragma once

#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks: `numbers` name the mesh's points everywhere. Throws the same InputError on all ranks, naming a
/// rank and a tet (1-based): for a face of three tets; where triangles are given by any rank, for a face of
/// one tet without a triangle; where none are, for two such faces at the same place.
void check_faces_of_parts(partition::Peers& peers, const Mesh& mesh,
                          const std::vector<std::uint64_t>& numbers);

}  // namespace weft::tools
