// Every rank reads the values of its slice; owners of vertices get them from there.
#include "tools/library/jobs/sources/metric_in_parts.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf_slice.h"
#include "meshing/metric/sources/hessian.h"
#include "meshing/metric/sources/multiscale.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/metric/part_domain.h"
#include "tools/common/naming.h"

namespace weft::tools {
namespace {

using partition::MeshSlice;
using partition::PartDomain;
using partition::Peers;

bool is_gmf_solution(const std::string& file) {
  const std::string extension = std::filesystem::path(file).extension();
  return extension == ".solb" || extension == ".sol";
}

/// The values of a file at this rank's slice of points. `kind`: what it is called where it is of another
/// mesh.
Fields read_slice_of(const std::string& file, const MeshSlice& slice, const std::string& kind) {
  const meshing::GmfLayout layout = meshing::read_gmf_layout(file);
  if (layout.num_solution_points() != slice.num_points)
    throw InputError(file, "",
                     kind + " of another mesh: it has " + std::to_string(layout.num_solution_points()) +
                         " vertices, the mesh " + std::to_string(slice.num_points));
  return meshing::read_gmf_solution_slice(file, layout, slice.first_point, slice.points.size());
}

/// The scalar fields at the vertices of the part.
Fields of_part(const PartDomain& domain, const Fields& of_slice) {
  Fields fields{domain.mesh().points.size(), {}};
  for (const Field& field : of_slice.fields)
    if (field.kind == Field::Kind::scalar)
      fields.fields.push_back({field.kind, domain.from_slices(field.values), field.name});
  return fields;
}

/// The scalar fields of a file, checked, at the vertices of the part.
Fields read_fields(Peers& peers, const MeshSlice& slice, const PartDomain& domain, const std::string& file) {
  Fields of_slice;
  partition::agree_on(peers, [&] {
    of_slice = read_slice_of(file, slice, "solution");
    meshing::scalar_fields(of_slice, slice.points.size(), file, slice.first_point);
  });
  return of_part(domain, of_slice);
}

meshing::LogMetricField read_metric(Peers& peers, const MeshSlice& slice, const PartDomain& domain,
                                    const std::string& file) {
  meshing::LogMetricField of_slice;
  partition::agree_on(peers, [&] { of_slice = metric_of_slice(file, slice); });
  return domain.from_slices(of_slice);
}

/// The whole boundary, and the vertices of the part: those with `numbers` in the whole mesh, ascending.
meshing::MeshData boundary_with(const MeshSlice& slice, const PartDomain& domain,
                                std::vector<std::uint32_t>& numbers) {
  meshing::MeshData mesh = slice.boundary;
  mesh.association = {};
  numbers = domain.numbers();
  for (const auto& triangle : mesh.triangles) numbers.insert(numbers.end(), triangle.begin(), triangle.end());
  for (const auto& edge : mesh.edges) numbers.insert(numbers.end(), edge.begin(), edge.end());
  numbers.insert(numbers.end(), mesh.corners.begin(), mesh.corners.end());
  numbers.insert(numbers.end(), mesh.required_points.begin(), mesh.required_points.end());
  std::ranges::sort(numbers);
  numbers.erase(std::ranges::unique(numbers).begin(), numbers.end());
  const auto renumber = [&](std::uint32_t& v) {
    v = static_cast<std::uint32_t>(std::ranges::lower_bound(numbers, v) - numbers.begin());
  };
  for (auto& triangle : mesh.triangles) std::ranges::for_each(triangle, renumber);
  for (auto& edge : mesh.edges) std::ranges::for_each(edge, renumber);
  std::ranges::for_each(mesh.corners, renumber);
  std::ranges::for_each(mesh.required_points, renumber);
  mesh.points = domain.from_slices(slice.points, numbers);
  mesh.point_refs.resize(mesh.points.size());
  return mesh;
}

/// The boundary is on every rank, and each looks at it from its own vertices.
std::optional<meshing::LogMetricField> demand_in_part(const MetricOptions& options, const MeshSlice& slice,
                                                      const PartDomain& domain,
                                                      const std::shared_ptr<const meshing::Model>& model) {
  if (!has_demand(options)) return std::nullopt;
  std::vector<std::uint32_t> numbers;
  const meshing::MeshData mesh = boundary_with(slice, domain, numbers);
  const meshing::LogMetricField demand = *boundary_demand(options, mesh, model, domain.largest_size());
  meshing::LogMetricField of_part;
  auto at = numbers.begin();
  for (const std::uint32_t number : domain.numbers()) {
    at = std::lower_bound(at, numbers.end(), number);
    of_part.push_back(demand[static_cast<std::size_t>(at - numbers.begin())]);
  }
  return of_part;
}

}  // namespace

bool can_be_made_in_parts(const MetricOptions& options) {
  return std::ranges::all_of(files_of(options), is_gmf_solution);
}

meshing::LogMetricField metric_of_slice(const std::string& file, const MeshSlice& slice) {
  return meshing::metric_from_solution(read_slice_of(file, slice, "metric"), slice.points.size(), file,
                                       slice.first_point);
}

LogMetricMade make_metric_in_parts(Peers& peers, const MetricOptions& options, const MeshSlice& slice,
                                   const std::string& mesh_name,
                                   const std::shared_ptr<const meshing::Model>& model) {
  const PartDomain domain = naming(mesh_name, [&] {
    const bool resolves = !options.sol.empty() || !options.solutions.empty();
    return PartDomain(peers, slice, resolves ? meshing::rings_of(options.recovery) : 1);
  });
  MetricOptions here = options;
  for (Fields& solution : here.solutions) solution = of_part(domain, solution);
  std::optional<meshing::LogMetricField> source;
  const bool given = partition::max(peers, slice.log_metrics.empty() ? 0 : 1) != 0;
  if (given) source = domain.from_slices(slice.log_metrics);
  LogMetricMade made = make_log_metric(
      here,
      {domain, [&](const std::string& file) { return read_fields(peers, slice, domain, file); },
       [&](const std::string& file) { return read_metric(peers, slice, domain, file); },
       [&] { return demand_in_part(options, slice, domain, model); }, source ? &*source : nullptr},
      mesh_name);
  made.field = domain.to_slices(made.field);
  return made;
}

}  // namespace weft::tools
