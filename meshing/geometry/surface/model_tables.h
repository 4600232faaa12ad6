// Patches and curves that lie on a model have its shape.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/geometry/model/boundary_domain.h"
#include "meshing/geometry/surface/joint_refs.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_curves.h"
#include "meshing/geometry/surface/surface_tables.h"

namespace weft::meshing {

/// Of the ends of features, among the edges (sorted by vertices) that lie on the model; zeros of others.
std::vector<std::array<double, 2>> parameters_at(std::span<const Surface::FeatureEdge> features,
                                                 std::span<const EdgeOnModel> edges);

/// Puts planes of the model in the place of those fitted to the points, for SurfaceTables::model; joint
/// references become references. `patch_faces`: faces of each patch's triangles, ascending.
void put_patches_on_model(const JointRefs& triangle_refs, std::vector<std::vector<std::uint32_t>> patch_faces,
                          SurfaceTables& tables);
/// The same for lines, when patches are on the model. `curve_patches`: of each curve that is on no edge of
/// the model, the patches of the triangles at its first edge, in their order.
void put_curves_on_model(const JointRefs& edge_refs, std::span<const std::vector<PatchId>> curve_patches,
                         std::span<const FoundCurve> curves, SurfaceTables& tables);

}  // namespace weft::meshing
