// How a mesh lies on the CAD model of its surface, and what is recorded of that.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/geometry/surface/surface.h"
#include "meshing/kernel/tet_mesh.h"
#include "weft/data.h"

namespace weft::meshing {

/// What is known of one entity of the model; of several parts of a mesh it adds up.
struct ModelEntitySums {
  ModelEntityAccount::Kind kind = ModelEntityAccount::Kind::node;
  std::uint32_t entity = 0;
  std::uint64_t vertices = 0, measured = 0;         ///< `measured`: triangles or mesh edges
  double distance = 0, largest = 0, deviation = 0;  ///< distances of vertices: the sum, the largest
};

/// What is known of the normals of the triangles on a face of the model, seen from tets of one reference:
/// interfaces have two sides, and a face of the model may bound several regions.
struct ModelNormalSums {
  std::uint32_t face = 0;
  std::int32_t ref = 0;
  double side = 0;  ///< of the normals: along the face's own, or against
  double least_cosine = 1, largest_cosine = -1;
  std::uint64_t along = 0, against = 0;
  void add(const ModelNormalSums& more);
};

/// An account before it is closed.
struct ModelSums {
  std::uint64_t vertices = 0, triangles = 0, unclassified_triangles = 0;
  std::uint64_t off = 0;  ///< vertices off the model
  double distance = 0, largest = 0;
  std::vector<std::pair<double, std::uint32_t>> listed;  ///< (distance, vertex) of those off
  std::vector<ModelEntitySums> entities;                 ///< by kind and entity
  std::vector<ModelNormalSums> normals;                  ///< by face and reference
};

/// What of a part of a mesh counts, where other parts have some of it too: flags for the records of
/// associate() (nodes, edges, faces) for their entities' sums, for vertices in the totals, and for boundary
/// faces in the order of export_mesh(). Empty: everything.
struct ModelShare {
  std::vector<std::uint8_t> records, vertices, triangles;
};

/// The surface has a model.
ModelSums sum_on_model(const TetMesh& mesh, const Surface& surface, const ModelShare& share = {},
                       std::vector<double>* deviations = nullptr);
ModelAccount account_of(const Model& model, ModelSums sums);

/// Distances of boundary vertices from their entities, deviations of faces and edges. A vertex is off the
/// model beyond kOffModel of the model's size and its entity's tolerance. `deviations`: where not null, for
/// each vertex slot the largest distance from the model of the centroids of the boundary faces around it; NaN
/// where there is none. The surface has a model.
ModelAccount account_on_model(const TetMesh& mesh, const Surface& surface,
                              std::vector<double>* deviations = nullptr);

/// The records for files: every vertex, numbered by `places` of its slot, with the node, the edges and the
/// faces that it lies on.
Association associate(const TetMesh& mesh, const Surface& surface, std::span<const std::uint32_t> places);

}  // namespace weft::meshing
