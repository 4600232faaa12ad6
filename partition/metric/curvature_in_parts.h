// What the curvature of the boundary asks for, on a mesh in parts.
#pragma once

#include <memory>

#include "meshing/geometry/model/model.h"
#include "meshing/metric/sources/curvature_metric.h"
#include "partition/communication/peers.h"
#include "partition/metric/part_domain.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// All ranks: meshing::curvature_metric() of the mesh of all slices, at the vertices of this rank's part; the
/// same bits for any number of ranks and any shares. The surface is built as that of a distribution
/// (surface/surface_parts.h), and a rank has the pieces of it that are near its own vertices.
meshing::LogMetricField curvature_in_parts(Peers& peers, const MeshSlice& slice, const PartDomain& domain,
                                           const meshing::CurvatureOptions& options,
                                           const std::shared_ptr<const meshing::Model>& model);

/// All ranks: whether the boundary of the mesh of all slices has curved surfaces, as far as the directions of
/// its triangles tell; the same for any shares.
bool may_curve(Peers& peers, const MeshSlice& slice, double ridge_angle_degrees);

}  // namespace weft::partition
