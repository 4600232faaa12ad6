// Mesh first, then what is at its vertices.
#include "tools/library/jobs/sources/repaired_input.h"

#include <iterator>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/repair_metric.h"
#include "meshing/metric/sources/multiscale.h"
#include "tools/common/naming.h"

namespace weft::tools {
namespace {

/// Of the mesh as it was read: `points` are of what it has become. Errors call the fields `name`.
Fields mended_fields(const Fields& fields, const std::string& name, std::size_t points_read,
                     const std::vector<std::uint32_t>& points) {
  if (fields.num_points != points_read)
    throw InputError(name, "",
                     "is of another mesh: it has " + std::to_string(fields.num_points) +
                         " vertices, the mesh " + std::to_string(points_read));
  return fields_at(fields, points);
}

Fields read_for(const std::string& file, std::size_t points_read, const std::vector<std::uint32_t>& points) {
  return mended_fields(meshing::read_solution(file), file, points_read, points);
}

void append(std::vector<Mend> more, std::vector<Mend>& mends) {
  mends.insert(mends.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

std::vector<Mend> mends_of(std::span<const meshing::MeshMend> mends) {
  std::vector<Mend> all;
  for (const meshing::MeshMend& m : mends)
    all.push_back({m.what, m.entity, m.count, m.examples, m.amount, m.unit});
  return all;
}

Fields fields_at(const Fields& fields, const std::vector<std::uint32_t>& points) {
  Fields result{points.size(), {}};
  for (const Field& field : fields.fields) {
    const auto width = static_cast<std::size_t>(components(field.kind));
    Field kept{field.kind, {}, field.name};
    kept.values.reserve(width * points.size());
    for (const std::uint32_t p : points)
      for (std::size_t c = 0; c < width; ++c) kept.values.push_back(field.values.at(width * p + c));
    result.fields.push_back(std::move(kept));
  }
  return result;
}

RepairedMetric repair_input(meshing::MeshData& mesh, const std::string& file, MetricOptions& options,
                            Fields& fields) {
  RepairedMetric result;
  const std::size_t points_read = mesh.points.size();
  meshing::MeshRepair repair = naming(file, [&] { return meshing::repair_mesh(mesh); });
  append(mends_of(repair.mends), result.mends);
  if (!fields.fields.empty()) fields = fields_at(fields, repair.points);
  if (!options.file.empty()) {
    Fields metric = read_for(options.file, points_read, repair.points);
    append(mends_of(naming(options.file, [&] { return meshing::repair_metric(mesh, metric); })),
           result.mends);
    result.source = meshing::metric_from_solution(metric, mesh.points.size(), options.file);
    options.file.clear();
  }
  for (Fields& solution : options.solutions)
    solution = mended_fields(solution, "solution", points_read, repair.points);
  for (const std::string& solution : options.sol) {
    options.solutions.push_back(read_for(solution, points_read, repair.points));
    meshing::scalar_fields(options.solutions.back(), mesh.points.size(), solution);  // a fault is the file's
  }
  options.sol.clear();
  result.points = std::move(repair.points);
  return result;
}

RepairedMetric repair_background(meshing::MeshData& mesh, const std::string& file, MetricOptions& options) {
  Fields none;
  RepairedMetric result = repair_input(mesh, file, options, none);
  for (Mend& mend : result.mends) mend.entity = "background's " + mend.entity;
  return result;
}

}  // namespace weft::tools
