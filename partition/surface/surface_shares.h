// The surface of the boundary, built in shares: each rank has the topology and the shape of the triangles
// near its own.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/surface/boundary_share.h"
#include "partition/surface/surface_parts.h"

namespace weft::partition {

/// Twice triangles are dealt to the ranks along a Morton curve, with two rings of others around each share:
/// evenly, for patches, curves, planes and what is told of vertices; then by pieces of the surface, for the
/// shape and the pieces. With a model (or null) each share is classified on it first. Patches, curves, names
/// and pieces are those of the whole surface, for any number of ranks. All ranks know patches, curves and
/// feature edges (some 150 bytes each), and which vertices are on the model's nodes. Takes the boundary and
/// adds to the warnings; none, and the boundary in other shares, where a patch does not agree with itself:
/// what becomes of it depends on an order of all its triangles. All ranks call together, and throw alike.
std::optional<SurfaceParts> build_surface_in_shares(Peers& peers, BoundaryShare& boundary,
                                                    const FetchPoints& points, double ridge_angle_degrees,
                                                    const std::shared_ptr<const meshing::Model>& model,
                                                    std::vector<std::string>& warnings);

}  // namespace weft::partition
