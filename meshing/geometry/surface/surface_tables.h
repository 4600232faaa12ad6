// What all parts of a surface share: patches and curves with their formulas, and the CAD model.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "meshing/geometry/model/model.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_shape.h"

namespace weft::meshing {

struct SurfaceTables {
  std::vector<Patch> patches;
  std::vector<Plane> planes;  ///< patch -> plane; of planar ones
  std::vector<Curve> curves;
  std::vector<Line> lines;  ///< curve -> line; of straight ones
  /// Whether a curve's edges are in pieces: where nobody can ask for one they are left out.
  std::vector<std::uint8_t> curve_in_pieces;

  std::shared_ptr<const Model> model;  ///< null: all is reconstructed, and the rest is empty
  std::vector<std::vector<std::uint32_t>> patch_faces;
  std::vector<std::uint32_t> curve_edge;
  std::vector<std::uint32_t> curve_patch;  ///< of a curve amid one patch's faces: a patch; else kNone

  bool is_on_model(PatchId patch) const { return model && !patch_faces[patch.value].empty(); }
  bool has_formula(PatchId patch) const {
    return patch_faces[patch.value].size() == 1 && model->has_formula(patch_faces[patch.value][0]);
  }
};

/// What is known of the mesh that a surface was built of: by its triangles and vertices.
struct SurfaceInput {
  std::vector<PatchId> triangle_patch;
  std::vector<Surface::FeatureEdge> features;
  std::vector<VertexKind> vertex_kind;
  std::vector<std::uint32_t> vertex_hint;
};

/// Curves and lines, as their edges tell.
void take_curves(std::span<const FoundCurve> found, SurfaceTables& tables);

class SurfaceCutter;

struct BuiltSurface {
  std::shared_ptr<const SurfaceTables> tables;
  SurfaceInput input;
  std::shared_ptr<const SurfaceCutter> cutter;  ///< of the pieces; reads the mesh's points
};

/// See Surface's constructors; `classification` may be of no model.
BuiltSurface build_surface(const MeshData& mesh, const Surface::Options& options,
                           ModelClassification&& classification);

}  // namespace weft::meshing
