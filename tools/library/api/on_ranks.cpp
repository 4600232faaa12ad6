// Shares are read, worked on together, and written together.
#include "weft/on_ranks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/io/ugrid.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/fields/measure_slices.h"
#include "partition/fields/slice_files.h"
#include "partition/fields/slice_pieces.h"
#include "partition/fields/transfer_in_parts.h"
#include "partition/verify/verify_slices.h"
#include "tools/common/inputs.h"
#include "tools/library/jobs/outputs.h"
#include "tools/library/jobs/sources/field_source.h"
#include "tools/library/jobs/sources/metric_in_parts.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/jobs/sources/shares.h"
#include "tools/library/jobs/sources/slice_source.h"
#include "tools/library/jobs/world.h"

namespace weft {
namespace {

using partition::MeshSlice;
using partition::Peers;

/// A mesh file's share; warns where rank 0 has read all of it.
tools::MeshShare read_mesh(Peers& peers, const std::string& file, DoneOnRanks& done,
                           meshing::OtherVolumes others = meshing::OtherVolumes::refused) {
  tools::MeshShare share = tools::read_mesh_share(peers, file, others);
  if (share.read_whole && peers.ranks() > 1)
    done.warnings.push_back(tools::read_whole_warning(file, "meshes"));
  return share;
}

void warn_of_fields(Peers& peers, const std::vector<std::string>& files, DoneOnRanks& done) {
  for (const std::string& file : files)
    if (peers.ranks() > 1 && !tools::fields_in_shares(file))
      done.warnings.push_back(tools::read_whole_warning(file, "fields"));
}

/// Of each rank, which reads it itself.
std::shared_ptr<const meshing::Model> read_model(Peers& peers, const GeometryOptions& geometry,
                                                 const std::string& mesh) {
  std::shared_ptr<const meshing::Model> model;
  partition::agree_on(peers, [&] {
    meshing::MeshData carrier;
    if (geometry.model == "carried") carrier.association = meshing::read_carried_model(mesh);
    model = tools::model_of(geometry, carrier, mesh);
  });
  return model;
}

/// The metric that the options ask for at the points of the slice, scaled and limited. One that is taken as
/// it is asks nothing of the mesh.
void add_metric(Peers& peers, const MetricOptions& options, const std::string& mesh,
                const std::shared_ptr<const meshing::Model>& model, MeshSlice& slice, DoneOnRanks& done) {
  warn_of_fields(peers, tools::files_of(options), done);
  if (tools::only_scaled(options) && options.complexity <= 0) {
    slice.log_metrics = tools::metric_of_share(peers, options, slice);
    return;
  }
  tools::LogMetricMade made = tools::make_metric_in_parts(peers, options, slice, mesh, model);
  slice.log_metrics = std::move(made.field);
  done.warnings.insert(done.warnings.end(), made.warnings.begin(), made.warnings.end());
}

void check_output(Peers& peers, const std::string& output) {
  partition::agree_on(peers, [&] {
    if (peers.rank() == 0) return tools::check_writable(output);
    meshing::require_part(output);  // on any host
  });
}

int number_in_environment(std::initializer_list<const char*> names, int otherwise) {
  for (const char* name : names)
    if (const char* text = std::getenv(name)) return std::atoi(text);
  return otherwise;
}

}  // namespace

PlaceOnRanks place_on_ranks() {
  if (!under_mpirun()) return {};
  return {number_in_environment({"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"}, 0),
          number_in_environment({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_NTASKS"}, 1)};
}

MetricOnRanks write_metric_on_ranks(const std::string& mesh, const MetricOptions& options,
                                    const std::string& output, const GeometryOptions& geometry, int threads) {
  Options all;
  all.metric = options;
  all.geometry = geometry;
  validate(all);
  MetricOnRanks result;
  const auto make = [&](Peers& peers) {
    check_output(peers, output);
    MeshSlice slice = read_mesh(peers, mesh, result).slice;
    add_metric(peers, options, mesh, read_model(peers, geometry, mesh), slice, result);
    result.vertices = slice.num_points;
    result.complexity = partition::complexity_of_slices(peers, slice);
    partition::write_fields_of_slices(peers, slice, meshing::solution_from_metric(slice.log_metrics), output);
  };
  result.first = tools::on_peers_of_world(make, threads);
  return result;
}

TransferOnRanks interpolate_on_ranks(const std::string& from, const std::vector<std::string>& files,
                                     const std::string& to, const std::string& output, TransferMethod method,
                                     int threads) {
  TransferOnRanks result;
  const auto transfer = [&](Peers& peers) {
    check_output(peers, output);
    const MeshSlice old = partition::without_boundary(read_mesh(peers, from, result).slice);
    const MeshSlice now = partition::without_boundary(read_mesh(peers, to, result).slice);
    warn_of_fields(peers, files, result);
    const Fields fields = tools::read_fields_of_slice(peers, files, old, from);
    result.transfer = tools::naming_meshes(
        from, to, [&] { return partition::transfer_in_parts(peers, old, fields, now, method); });
    result.vertices = now.num_points;
    result.fields = fields.fields.size();
    partition::write_fields_of_slices(peers, now, std::exchange(result.transfer.fields, {}), output);
  };
  result.first = tools::on_peers_of_world(transfer, threads);
  return result;
}

MeasuresOnRanks measure_on_ranks(const std::string& mesh, const MetricOptions& options) {
  MeasuresOnRanks result;
  const bool first = tools::on_peers_of_world([&](Peers& peers) {
    MeshSlice slice = read_mesh(peers, mesh, result).slice;
    result.counts = {slice.num_points, slice.num_tets, slice.num_triangles, slice.num_edges};
    const meshing::ContentCounts counts = tools::counts_of_slices(peers, slice);
    result.corners = counts.corners;
    result.ridges = counts.ridges;
    result.required_vertices = counts.required_points;
    result.required_edges = counts.required_edges;
    result.required_triangles = counts.required_triangles;
    partition::SlicesGeometry geometry = partition::measure_geometry_of_slices(peers, slice);
    if (slice.num_points > 0) {
      result.geometry.min = geometry.box.lo;
      result.geometry.max = geometry.box.hi;
    }
    result.geometry.shape = geometry.shape;
    result.geometry.volume_by_ref = std::move(geometry.volume_by_ref);
    result.geometry.area_by_ref = std::move(geometry.area_by_ref);
    if (!options.given()) return;
    add_metric(peers, options, mesh, nullptr, slice, result);
    result.measures = partition::measure_slices(peers, slice);
  });
  result.first = first;
  return result;
}

VerifiedOnRanks verify_on_ranks(const std::string& mesh, const std::string& against, int max_problems) {
  VerifiedOnRanks result;
  const bool first = tools::on_peers_of_world([&](Peers& peers) {
    const auto check = [&](const std::string& file, int most) {
      const MeshSlice slice = read_mesh(peers, file, result).slice;
      const std::string problem = partition::array_problem(peers, slice);
      if (!problem.empty()) throw InputError("", "", problem);  // as verify() does
      return partition::verify_slices(peers, slice, most);
    };
    result.report = check(mesh, max_problems);
    if (!against.empty()) result.against = check(against, 0);
  });
  result.first = first;
  return result;
}

namespace {

bool is_pvtu(const std::string& file) { return std::filesystem::path(file).extension() == ".pvtu"; }

/// Fields of the input itself, and of a file beside it.
Fields fields_to_convert(Peers& peers, const std::string& input, const std::string& solution,
                         const MeshSlice& slice, std::vector<Dropped>& dropped) {
  Fields fields{slice.points.size(), {}};
  if (meshing::is_mesh_name(input) && tools::has_own_fields_in_shares(input)) {
    tools::FieldsShare own = tools::read_own_fields_share(peers, input);
    fields = std::move(own.fields);
    partition::agree_on(peers, [&] { tools::check_values(input, fields, slice.first_point); });
    std::ranges::move(own.dropped, std::back_inserter(dropped));
  }
  if (solution.empty()) return fields;
  Fields more = tools::read_fields_share(peers, solution, slice, [&](std::uint64_t length) {
    return fmt::format("belongs to another mesh: it has {} vertices, {} has {}", length, input,
                       slice.num_points);
  });
  partition::agree_on(peers, [&] { tools::check_values(solution, more, slice.first_point); });
  std::ranges::move(more.fields, std::back_inserter(fields.fields));
  return fields;
}

}  // namespace

bool can_convert_on_ranks(const std::string& input, const std::string& solution, const std::string& output,
                          const WriteOptions& options) {
  try {
    const bool pieces = meshing::can_be_in_pieces(input);
    return (tools::has_own_fields_in_shares(input) || !meshing::holds_fields(input)) &&
           (pieces || meshing::can_be_streamed(input) || meshing::size_for_ranges(input)) &&
           !meshing::has_association(input) && (solution.empty() || tools::fields_in_shares(solution)) &&
           (is_pvtu(output) || partition::can_write_slices(output, options));
  } catch (const InputError&) {  // that whoever reads the file whole tells once
    return false;
  }
}

ConvertedOnRanks convert_on_ranks(const std::string& input, const std::string& solution,
                                  const std::string& output, const WriteOptions& options) {
  tools::keep_solution(input, output, solution);
  ConvertedOnRanks result;
  const bool first = tools::on_peers_of_world([&](Peers& peers) {
    check_output(peers, output);
    const tools::MeshShare share = read_mesh(peers, input, result, meshing::OtherVolumes::dropped);
    const MeshSlice& slice = share.slice;
    result.dropped = share.dropped;
    const Fields fields = fields_to_convert(peers, input, solution, slice, result.dropped);
    const bool beside = !fields.fields.empty() && !meshing::holds_fields(output);
    const std::string file = meshing::solution_beside(output).string();
    if (beside) check_output(peers, file);
    result.counts = {slice.num_points, slice.num_tets, slice.num_triangles, slice.num_edges};
    const bool has_mapbc = meshing::has_mapbc_for(input, output);
    RefNames names = share.names;
    if (has_mapbc) meshing::leave_to_mapbc(input, names, result.dropped);
    for (Dropped& lost : meshing::lost_in(output, tools::counts_of_slices(peers, slice), fields, names))
      result.dropped.push_back(std::move(lost));
    if (is_pvtu(output)) {
      WriteOptions of_pieces = options;
      if (of_pieces.pieces == 0) of_pieces.pieces = std::max(2, peers.ranks());
      return partition::write_slices_as_pvtu(peers, slice, fields, output, of_pieces);
    }
    partition::write_mesh_of_slices(peers, slice, fields, share.names, output, options);
    if (beside) partition::write_fields_of_slices(peers, slice, fields, file);
    partition::agree_on(peers, [&] {
      if (has_mapbc && peers.rank() == 0) meshing::copy_mapbc(input, output);
    });
  });
  result.first = first;
  return result;
}

}  // namespace weft
