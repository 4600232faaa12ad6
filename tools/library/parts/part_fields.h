// The fields of a mesh in parts on their way to slices, and from there to the parts of the result.
#pragma once

#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks: the fields of the parts at the points of the slices that slice_of_parts() makes of them; of a
/// point that several ranks have, the values of the lowest. A rank without points need not list them. Throws
/// InputError, the same on all ranks, where ranks have different numbers or kinds of fields.
Fields fields_of_slices(partition::Peers& peers, const Part& part);

/// All ranks: of fields at the points of the slices of a result, those at the points with these numbers.
Fields fields_at(partition::Peers& peers, const partition::MeshSlice& slice, const Fields& of_slice,
                 const std::vector<std::uint64_t>& numbers);

}  // namespace weft::tools
