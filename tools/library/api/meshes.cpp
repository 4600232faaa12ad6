// Reading and writing; simple meshes.
#include <utility>

#include "meshing/base/printable.h"
#include "meshing/initial/shapes.h"
#include "meshing/io/mesh_file.h"
#include "meshing/io/vtk/pvtu.h"
#include "meshing/mesh/structured_box.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/outputs.h"
#include "tools/library/jobs/sources/field_check.h"
#include "tools/library/jobs/sources/field_source.h"
#include "weft/weft.h"

namespace weft {

Mesh read_mesh(const std::string& path, RefNames* names) { return meshing::read_mesh(path, names); }

MeshFile read_mesh_file(const std::string& path) {
  meshing::MeshContents contents = meshing::read_mesh_contents(path);
  return {std::move(contents.mesh), std::move(contents.fields), std::move(contents.names),
          std::move(contents.dropped), contents.foreign_volumes};
}

Mesh read_mesh_by_piece(const std::string& path) { return meshing::read_pvtu_by_piece(path).mesh; }

Fields read_fields(const std::string& path) { return meshing::read_solution(path); }

Fields read_fields(const std::vector<std::string>& paths, std::size_t num_points,
                   const std::string& mesh_name) {
  return tools::read_all_fields(paths, num_points, mesh_name);
}

VertexCount count_vertices(const std::string& mesh) { return tools::count_vertices_of(mesh); }

Fields check_field_file(const std::string& path, const VertexCount& vertices, const std::string& mesh_name) {
  return tools::check_field_file(path, vertices, mesh_name);
}

Metric read_metric(const std::string& path, const Mesh& mesh) {
  return Metric::from_fields(meshing::read_solution(path), mesh.points.size(), path);
}

void write_mesh(const std::string& path, const Mesh& mesh, const Fields& fields, const RefNames& names) {
  const WholeMesh whole(mesh);
  check_fields(mesh, fields);
  tools::write_mesh_and_fields(path, *whole, fields, names);
}

void write_result(const std::string& path, const Mesh& mesh, const Metric& metric, const Fields& fields,
                  const RefNames& names) {
  const WholeMesh whole(mesh);
  check_length(mesh, metric.size(), "metric");
  check_fields(mesh, fields);
  tools::write_mesh_with_solution(tools::output_paths(path), *whole, metric.fields(), fields, names);
}

ResultFiles result_files(const std::string& path) {
  const tools::OutputPaths paths = tools::output_paths(path);
  return {paths.mesh, paths.solution, paths.fields};
}

std::vector<Dropped> write_mesh_file(const std::string& path, const MeshFile& contents,
                                     const WriteOptions& options) {
  const WholeMesh whole(contents.mesh);
  check_fields(contents.mesh, contents.fields);
  const meshing::MeshView view(*whole, contents.fields, contents.names);
  meshing::write_mesh_contents(path, view, options);
  return meshing::lost_in(path, meshing::counts_of(*whole), contents.fields, contents.names, options);
}

void write_fields(const std::string& path, const Fields& fields) { meshing::write_solution(path, fields); }

void write_text(const std::string& path, const std::string& text) { tools::write_text(path, text); }
void check_writable(const std::string& path) { tools::check_writable(path); }

std::string fields_beside(const std::string& mesh) { return meshing::solution_beside(mesh).string(); }
bool is_mesh_name(const std::string& path) { return meshing::is_mesh_name(path); }
bool holds_volumes(const std::string& path) { return meshing::holds_volumes(path); }
bool holds_fields(const std::string& path) { return meshing::holds_fields(path); }
std::string mesh_extensions() { return meshing::mesh_extensions(); }
std::string volume_extensions() { return meshing::volume_extensions(); }

std::string printable(const std::string& text) { return meshing::printable(text); }

Mesh box(const BoxOptions& options) { return meshing::structured_box(options); }
Mesh ball_surface(const BallOptions& options) { return meshing::ball_surface(options); }
Mesh cylinder_surface(const CylinderOptions& options) { return meshing::cylinder_surface(options); }
Mesh delta_wing_surface(const DeltaWingOptions& options) { return meshing::delta_wing_surface(options); }

}  // namespace weft
