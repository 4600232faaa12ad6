// The pieces of a whole surface.
#pragma once

#include <span>
#include <vector>

#include "meshing/geometry/model_classification.h"
#include "meshing/geometry/surface_tables.h"
#include "meshing/geometry/surface_topology.h"

namespace weft::meshing {

/// What there is to cut.
struct WholeSurface {
  std::span<const Point> points;
  const SurfaceTopology& topology;
  std::span<const std::array<Vec, 2>> handles;  ///< by edge; may be empty
  // With a model:
  const ModelClassification* classification = nullptr;
  std::span<const std::array<double, 2>> feature_t;  ///< parameters of a feature edge's ends
  const std::vector<bool>* turned = nullptr;         ///< triangles whose order is not the input's
};

/// Triangles of patches that have no formula along a Morton curve, then feature edges where the curve or a
/// triangle beside it is asked for. Sets `curve_in_pieces` of the tables.
struct SurfaceCut {
  SurfacePieces pieces;
  std::vector<std::uint32_t> vertex_hint;  ///< the topology's, as names
};
SurfaceCut cut_surface(const WholeSurface& whole, SurfaceTables& tables);

}  // namespace weft::meshing
