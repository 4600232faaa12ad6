// The surface of the boundary, built in shares: each rank has the topology and the shape of the triangles
// near its own.
#pragma once

#include <optional>

#include "partition/communication/peers.h"
#include "partition/surface/boundary_share.h"
#include "partition/surface/surface_parts.h"

namespace weft::partition {

/// Twice triangles are dealt to the ranks along a Morton curve, with two rings of others around each share:
/// evenly, for patches, curves, planes and what is told of vertices; then by pieces of the surface, for the
/// shape and the pieces. Patches, curves, names and pieces are those of the whole surface, for any number of
/// ranks. All ranks know patches, curves and feature edges (some 150 bytes each). Takes the boundary; none,
/// and the boundary in other shares, where a patch does not agree with itself: what becomes of it depends on
/// an order of all its triangles. All ranks call together.
std::optional<SurfaceParts> build_surface_in_shares(Peers& peers, BoundaryShare& boundary,
                                                    const FetchPoints& points, double ridge_angle_degrees);

}  // namespace weft::partition
