// A slice, with the points that its tets have from elsewhere, as a piece.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "partition/slice/slice_checks.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

struct SlicePiece {
  MeshPiece piece;
  std::vector<std::uint32_t> numbers;  ///< of its points in the whole mesh, ascending
};

/// All ranks: this rank's tets in their order, as the piece of a subdomain that has the rank's number, with
/// their vertices, all points of the slice and those of the numbers `more`. Without triangles, edges and the
/// references of points; without a metric that of the unit tensor.
SlicePiece piece_of_slice(Peers& peers, const MeshSlice& slice, SliceMetric metric = SliceMetric::given,
                          std::span<const std::uint32_t> more = {});

}  // namespace weft::partition
