// Which face, edge or node of a CAD model each part of a boundary triangulation lies on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "meshing/geometry/model/boundary_domain.h"
#include "meshing/geometry/model/model.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Of a part of a boundary: parameters are those of own triangles, nodes those at their vertices. The rest is
/// of all that is here.
struct ModelClassification {
  std::shared_ptr<const Model> model;
  /// Of each triangle; kNoEntity where it lies on none: there the surface is reconstructed from the
  /// triangles.
  std::vector<std::uint32_t> triangle_face;
  /// Faces that the mesh does not keep apart, because its triangles cross the edges between them, have one
  /// group, named by its lowest face.
  std::vector<std::uint32_t> face_group;
  /// Where the corners of a triangle lie on its face, unwrapped so that they may be interpolated. Empty where
  /// all faces have formulas.
  std::vector<std::array<Parameters, 3>> parameters;

  using Edge = EdgeOnModel;
  std::vector<Edge> edges;                                     ///< sorted by vertices
  std::vector<std::pair<std::uint32_t, std::uint32_t>> nodes;  ///< (vertex, node), sorted
  // Of the whole boundary:
  std::vector<std::string> warnings;
  /// As the mesh comes. Of triangles on a face with one reference, those that are listed as fewer are.
  ModelFaults faults;
};

/// Classifies `boundary`, which has all of a mesh's boundary and interface triangles, by the records that it
/// has of its vertices (where the model agrees with them) and by coordinates, references and listed edges.
/// Throws InputError naming the distance where the model is another body's: most vertices lie off it, or
/// little of either's area is common, or they are off as if scaled or shifted. O(n log n) for a given model.
ModelClassification classify_on_model(const MeshData& boundary, std::shared_ptr<const Model> model);
/// The same of a part of a boundary: to the bit what the whole has there. All parts call together, and throw
/// alike.
ModelClassification classify_on_model(const BoundaryDomain& part, std::shared_ptr<const Model> model);

}  // namespace weft::meshing
