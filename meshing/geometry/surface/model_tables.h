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

/// What is known of a surface on a model when its patches and curves have been formed.
struct SurfaceOnModel {
  JointRefs triangle_refs, edge_refs;
  std::vector<std::vector<std::uint32_t>> patch_faces;  ///< patch -> faces of its triangles, ascending
  /// Curve -> patches of the triangles at its first edge, in their order; of curves on no edge of the model.
  std::vector<std::vector<PatchId>> curve_patches;
};

/// Of the ends of features, among the edges (sorted by vertices) that lie on the model; zeros of others.
std::vector<std::array<double, 2>> parameters_at(std::span<const Surface::FeatureEdge> features,
                                                 std::span<const EdgeOnModel> edges);

/// Puts planes of the model in the place of those fitted to the points, for SurfaceTables::model; joint
/// references become references. Takes `patch_faces`.
void put_patches_on_model(SurfaceOnModel& on_model, SurfaceTables& tables);
/// The same for lines, when patches are on the model.
void put_curves_on_model(const SurfaceOnModel& on_model, std::span<const FoundCurve> curves,
                         SurfaceTables& tables);

}  // namespace weft::meshing
