// The surface of the boundary: patches and curves, which all ranks know, and what one of them knows beside.
#pragma once

#include <cstdint>
#include <memory>
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
  std::shared_ptr<const meshing::SurfaceCutter> cutter;  ///< of the pieces that this rank can make; or null
  /// What the cutter reads.
  std::shared_ptr<const meshing::MeshData> mesh;
};

/// Finds patches, curves and the shape of the surface, on a model or without: in shares (surface_shares.h);
/// on the last rank, which tells the others, where a patch has one side only. Gives the boundary back. Adds
/// to the warnings. All ranks call together, and throw alike.
SurfaceParts build_surface_parts(Peers& peers, BoundaryShare&& boundary, const FetchPoints& points,
                                 double ridge_angle_degrees,
                                 const std::shared_ptr<const meshing::Model>& model,
                                 std::vector<std::string>& warnings);

}  // namespace weft::partition
