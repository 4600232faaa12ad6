// What must be right in a share of the input before anything is done with it.
#pragma once

#include <optional>
#include <span>

#include "meshing/base/point.h"
#include "partition/communication/input_issue.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/distribute/mesh_slice.h"

namespace weft::partition {

/// Reference numbers that do not fit their entities, indices out of range and coordinates that are not
/// finite, in the order and the words of meshing::check_arrays: every rank throws the same InputError. Throws
/// std::invalid_argument where the shares do not make up the whole mesh. All ranks call together.
void check_slices(Peers& peers, const MeshSlice& slice, const Ranges& points, const Ranges& tets);

/// The first of these tets that is inverted or flat. corners[i] are the points of tet first_tet + i.
std::optional<InputIssue> find_inverted(const MeshSlice& slice,
                                        std::span<const std::array<const meshing::Point*, 4>> corners);

}  // namespace weft::partition
