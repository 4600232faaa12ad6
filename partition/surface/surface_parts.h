// The surface of the boundary, built in shares: patches and curves, which all ranks know, and what each of
// them knows beside.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "meshing/geometry/model/model.h"
#include "meshing/geometry/surface/cut_surface.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/geometry.h"
#include "partition/surface/boundary_index.h"
#include "partition/surface/boundary_share.h"

namespace weft::partition {

struct SurfaceParts {
  std::shared_ptr<Geometry> geometry;                    ///< `patch_inner` is left to others
  std::vector<std::uint64_t> triangles;                  ///< by patch, of the whole boundary
  BoundaryRecords records;                               ///< each of one rank
  std::shared_ptr<const meshing::SurfaceCutter> cutter;  ///< of the pieces that this rank can make
  /// What the cutter reads.
  std::shared_ptr<const meshing::MeshData> mesh;
};

/// Finds patches, curves and the shape of the surface: each rank of the triangles near its own. Twice
/// triangles are dealt to the ranks along a Morton curve, with two rings of others around each share: evenly,
/// for patches, curves, planes and what is told of vertices; then by pieces of the surface, for the shape and
/// the pieces. With a model (or null) each share is classified on it first. Patches, curves, names and pieces
/// are those of the whole surface, for any number of ranks. All ranks know patches and curves, and which
/// vertices are on the model's nodes. Gives the boundary back. Adds to the warnings. All ranks call together,
/// and throw alike.
SurfaceParts build_surface_parts(Peers& peers, BoundaryShare&& boundary, const FetchPoints& points,
                                 double ridge_angle_degrees,
                                 const std::shared_ptr<const meshing::Model>& model,
                                 std::vector<std::string>& warnings);

}  // namespace weft::partition
