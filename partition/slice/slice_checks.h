// What must be right in a share of the input before anything is done with it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "meshing/base/point.h"
#include "partition/communication/input_issue.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// Whether the slices have metrics; before one is made they have none.
enum class SliceMetric { given, missing };

/// Reference numbers that do not fit their entities, indices out of range and coordinates that are not
/// finite, in the order and the words of meshing::check_arrays: every rank throws the same InputError. Throws
/// std::invalid_argument where the shares do not make up the whole mesh. All ranks call together.
void check_slices(Peers& peers, const MeshSlice& slice, const Ranges& points, const Ranges& tets,
                  SliceMetric metric = SliceMetric::given);

/// What is wrong with a tet that is inverted or flat, by its number and those of its vertices in the whole
/// mesh.
std::optional<InputIssue> inverted(std::uint64_t number, const std::array<std::uint32_t, 4>& vertices,
                                   const std::array<const meshing::Point*, 4>& corners);

}  // namespace weft::partition
