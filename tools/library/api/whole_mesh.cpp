#include "tools/library/api/whole_mesh.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "meshing/mesh/problems.h"

namespace weft {
namespace {

template <class Entities>
bool lacks(const Entities& entities, const std::vector<std::int32_t>& refs) {
  return refs.empty() && !entities.empty();
}

void check_field(const Mesh& mesh, const Field& field, std::size_t number) {
  const std::string entity = "field " + std::to_string(number + 1);
  const auto width = static_cast<std::size_t>(components(field.kind));
  if (field.values.size() != width * mesh.points.size())
    throw InputError("", entity,
                     fmt::format("has {} values, not {} for each of the {} vertices", field.values.size(),
                                 width, mesh.points.size()));
  for (std::size_t i = 0; i < field.values.size(); ++i)
    if (!std::isfinite(field.values[i]))
      throw InputError("", entity, fmt::format("vertex {}: not a finite number", i / width + 1));
}

}  // namespace

WholeMesh::WholeMesh(const Mesh& mesh, meshing::CollapsedTriangles collapsed) : mesh_(mesh) {
  if (lacks(mesh.points, mesh.point_refs) || lacks(mesh.tets, mesh.tet_refs) ||
      lacks(mesh.triangles, mesh.triangle_refs) || lacks(mesh.edges, mesh.edge_refs)) {
    completed_ = mesh;
    if (mesh.point_refs.empty()) completed_->point_refs.assign(mesh.points.size(), 0);
    if (mesh.tet_refs.empty()) completed_->tet_refs.assign(mesh.tets.size(), 0);
    if (mesh.triangle_refs.empty()) completed_->triangle_refs.assign(mesh.triangles.size(), 0);
    if (mesh.edge_refs.empty()) completed_->edge_refs.assign(mesh.edges.size(), 0);
  }
  meshing::Problems problems(1);
  meshing::check_arrays(**this, problems, collapsed);
  if (problems.count() > 0) throw InputError("", "", problems.take().front());
}

void check_length(const Mesh& mesh, std::size_t values, const char* what) {
  if (values == mesh.points.size()) return;
  throw InputError(
      "", "",
      fmt::format("{} of another mesh: it has {} vertices, the mesh {}", what, values, mesh.points.size()));
}

void check_fields(const Mesh& mesh, const Fields& fields) {
  if (!fields.fields.empty()) check_length(mesh, fields.num_points, "field");
  for (std::size_t f = 0; f < fields.fields.size(); ++f) check_field(mesh, fields.fields[f], f);
}

}  // namespace weft
