// Mends of meshes, metrics and surfaces.
#include <fmt/format.h>

#include "meshing/initial/repair_surface.h"
#include "meshing/mesh/repair/repair_mesh.h"
#include "meshing/metric/repair_metric.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/sources/repaired_input.h"
#include "weft/weft.h"

namespace weft {

std::vector<Mend> repair(Mesh& mesh, Fields* fields) {
  if (fields) check_fields(mesh, *fields);
  const meshing::MeshRepair repair = meshing::repair_mesh(mesh);
  if (fields && !fields->fields.empty()) *fields = tools::fields_at(*fields, repair.points);
  return tools::mends_of(repair.mends);
}

std::vector<Mend> repair_metric(const Mesh& mesh, Fields& fields) {
  check_length(mesh, fields.num_points, "metric");
  return tools::mends_of(meshing::repair_metric(*WholeMesh(mesh), fields));
}

std::vector<Mend> repair_surface(Mesh& surface) { return tools::mends_of(meshing::repair_surface(surface)); }

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
