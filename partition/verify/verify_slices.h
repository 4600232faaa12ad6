// The full check of a mesh that ranks have in shares.
#pragma once

#include <string>

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "weft/data.h"

namespace weft::partition {

/// All ranks: what meshing::check_mesh() finds of the whole mesh, in its words and its order, on all ranks;
/// volumes and areas but for rounding. No rank has more than its shares, and the tets, triangles and edges at
/// its points: 250 bytes a tet of the share where these are in the order of the points.
meshing::CheckReport verify_slices(Peers& peers, const MeshSlice& slice, int max_problems = 20);

/// All ranks: the first thing that is wrong with the arrays alone, in the words of meshing::check_arrays();
/// empty where nothing is.
std::string array_problem(Peers& peers, const MeshSlice& slice);

}  // namespace weft::partition
