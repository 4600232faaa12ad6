// From plain arrays to the kernel's mesh and back: the only two doors.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "meshing/geometry/surface/surface.h"
#include "meshing/kernel/tet_mesh.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/background.h"
#include "meshing/metric/metric_field.h"

namespace weft::meshing {

/// A mesh ready for the kernel, and the geometry of its boundary.
struct ImportedMesh {
  std::unique_ptr<TetMesh> mesh;
  std::unique_ptr<Surface> surface;
  Adjacency adjacency;               ///< of the input's tets
  std::vector<bool> patch_required;  ///< patches made of required triangles
  std::vector<std::string>
      warnings;          ///< what was repaired: missing triangles created, unused points dropped ...
  ModelFaults on_model;  ///< of the input
};

/// Throws InputError (no file name) for arrays of reference numbers that do not fit their entities, indices
/// out of range and coordinates that are not finite. What has passed can be read without further care.
void check_arrays(const MeshData& mesh);

/// Checks `input` and builds the kernel's mesh with room for `vertex_capacity` and `tet_capacity`. Throws
/// InputError (no file name) naming the entity, 1-based: index out of range, inverted or duplicate tet, faces
/// of three tets, triangle that is no face. Boundary or interface triangles that are missing are created,
/// with a warning; edges at which the mesh touches itself become required. Metrics and qualities are not set
/// yet. With a model the boundary is classified on it (classify_on_model).
ImportedMesh import_mesh(const MeshData& input, double ridge_angle_degrees, std::size_t vertex_capacity,
                         std::size_t tet_capacity, std::shared_ptr<const Model> model = nullptr);

/// Reads the metric of every vertex from the background (directly where the background is the input mesh).
/// Vertex ids must still be those of the input.
void read_metric(TetMesh& mesh, const Background& background, bool background_is_input);

/// The place of each live vertex among all that are, by slot; holes have none.
std::vector<std::uint32_t> places_of_vertices(const TetMesh& mesh, std::uint32_t& count);

/// Plain arrays and metrics, in the order of slots without the holes.
void export_mesh(const TetMesh& mesh, const Surface& surface, const std::vector<bool>& patch_required,
                 MeshData& data, LogMetricField& log_metrics);

}  // namespace weft::meshing
