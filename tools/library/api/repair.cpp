// Mends of meshes, metrics and surfaces.
#include <fmt/format.h>

#include "meshing/initial/repair_surface.h"
#include "meshing/mesh/repair/repair_mesh.h"
#include "meshing/metric/repair_metric.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/sources/repaired_input.h"
#include "weft/weft.h"

namespace weft {
namespace {

void check_references(std::size_t entities, const std::vector<std::int32_t>& refs, const char* what) {
  if (!refs.empty() && refs.size() != entities)
    throw InputError("", "", fmt::format("{} references of {} {}", refs.size(), entities, what));
}

void check_references(const Mesh& mesh) {
  check_references(mesh.points.size(), mesh.point_refs, "vertices");
  check_references(mesh.tets.size(), mesh.tet_refs, "tets");
  check_references(mesh.triangles.size(), mesh.triangle_refs, "triangles");
  check_references(mesh.edges.size(), mesh.edge_refs, "edges");
}

}  // namespace

std::vector<Mend> repair(Mesh& mesh, Fields* fields) {
  if (fields) check_fields(mesh, *fields);
  check_references(mesh);
  const meshing::MeshRepair repair = meshing::repair_mesh(mesh);
  if (fields && !fields->fields.empty()) *fields = tools::fields_at(*fields, repair.points);
  return tools::mends_of(repair.mends);
}

std::vector<Mend> repair_metric(const Mesh& mesh, Fields& fields) {
  check_length(mesh, fields.num_points, "metric");
  for (const Field& field : fields.fields)
    check_length(mesh, field.values.size() / static_cast<std::size_t>(components(field.kind)), "metric");
  return tools::mends_of(meshing::repair_metric(*WholeMesh(mesh), fields));
}

std::vector<Mend> repair_surface(Mesh& surface) {
  const WholeMesh whole(surface, meshing::CollapsedTriangles::allowed);
  if (&*whole != &surface) surface = Mesh(*whole);
  return tools::mends_of(meshing::repair_surface(surface));
}

std::string mends_text(std::span<const Mend> mends) {
  std::string text;
  for (const Mend& m : mends) {
    std::string examples;
    for (const std::uint64_t e : m.examples) examples += (examples.empty() ? " " : ", ") + std::to_string(e);
    text += fmt::format(
        "repaired: {} {} ({}{}{}){}\n", m.count, m.what, m.entity, examples,
        m.count > m.examples.size() ? " ..." : "",
        m.unit.empty() || m.amount == 0 ? "" : fmt::format(", {} up to {:.3g}", m.unit, m.amount));
  }
  return text;
}

}  // namespace weft
