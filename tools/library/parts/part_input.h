// A caller's mesh in parts becomes the slices that the decomposition starts from.
#pragma once

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks: the slices of the mesh that the parts make up, checked. Points are numbered in the order of
/// their ids, tets in that of their ids, or of ranks and arrays where they have none. Throws the same
/// InputError on all ranks, naming the rank, the entity (1-based, or by its ids) and the reason: arrays that
/// do not fit, one id for two points, a tet on two ranks, holes between parts. `metric`: null on all ranks or
/// on none; the slices have none then.
partition::MeshSlice slice_of_parts(partition::Peers& peers, const Part& part, const Metric* metric);

}  // namespace weft::tools
