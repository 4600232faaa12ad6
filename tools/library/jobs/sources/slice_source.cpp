// Shares of files, or of a mesh that rank 0 has.
#include "tools/library/jobs/sources/slice_source.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/fields/by_components.h"
#include "tools/library/jobs/sources/field_source.h"
#include "tools/library/jobs/sources/metric_in_parts.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/jobs/sources/repaired_input.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using meshing::InputError;
using meshing::MeshData;
using partition::MeshSlice;
using partition::Peers;

bool is_gmf(const std::string& file) {
  const std::string extension = fs::path(file).extension();
  return extension == ".meshb" || extension == ".mesh" || extension == ".solb" || extension == ".sol";
}

/// Whether nothing asks how the metric is elsewhere: every rank can do with its share of the points.
bool only_scaled(const MetricOptions& m) {
  return scaled_alone(m) && (m.file.empty() || is_gmf(m.file)) && m.file.empty() != m.function.empty();
}

/// Whether no rank needs the whole mesh, where ranges of the file can be read.
bool possible_in_shares(const Files& files, const Options& options) {
  return !options.run.repair && files.background.empty() && std::ranges::all_of(files.fields, is_gmf) &&
         (only_scaled(options.metric) ||
          (options.metric.solutions.empty() && can_be_made_in_parts(options.metric)));
}

struct Share {
  std::uint64_t first, count;
};
Share share_of(std::uint64_t total, int rank, int ranks) {
  const auto r = static_cast<std::uint64_t>(rank), n = static_cast<std::uint64_t>(ranks);
  const std::uint64_t first = total * r / n;
  return {first, total * (r + 1) / n - first};
}

meshing::LogMetricField metric_of_share(const MetricOptions& request, const MeshSlice& slice) {
  if (!request.function.empty()) {
    MeshData points;
    points.points = slice.points;
    return meshing::sample(meshing::AnalyticMetric(request.function), points);
  }
  return metric_of_slice(request.file, slice);
}

/// The file's share of this rank.
MeshSlice slice_of_file(const std::string& file, const meshing::MeshSize& size, Share points, Share tets,
                        meshing::RefNames& names) {
  if (size.tets == 0) throw InputError(file, "", "has no tetrahedra");
  meshing::MeshContents part =
      meshing::read_mesh_range(file, {points.first, points.count, tets.first, tets.count});
  MeshSlice slice;
  slice.num_points = size.points;
  slice.num_tets = size.tets;
  slice.first_point = points.first;
  slice.first_tet = tets.first;
  slice.boundary = std::move(part.mesh);
  slice.points = std::exchange(slice.boundary.points, {});
  slice.point_refs = std::exchange(slice.boundary.point_refs, {});
  slice.tets = std::exchange(slice.boundary.tets, {});
  slice.tet_refs = std::exchange(slice.boundary.tet_refs, {});
  names = std::move(part.names);
  return slice;
}

SliceInput read_share(Peers& peers, const Files& files, const Options& options, const meshing::MeshSize& size,
                      const std::shared_ptr<const meshing::Model>& model) {
  SliceInput input;
  partition::agree_on(peers, [&] {
    const Share points = share_of(size.points, peers.rank(), peers.ranks());
    const Share tets = share_of(size.tets, peers.rank(), peers.ranks());
    input.slice = slice_of_file(files.input, size, points, tets, input.names);
    if (only_scaled(options.metric)) input.slice.log_metrics = metric_of_share(options.metric, input.slice);
    input.fields = read_fields_of_slice(files.fields, input.slice, files.input);
  });
  if (only_scaled(options.metric)) {
    input.target_complexity = options.metric.complexity;
    return input;
  }
  LogMetricMade made = make_metric_in_parts(peers, options.metric, input.slice, files.input, model);
  input.slice.log_metrics = std::move(made.field);
  input.warnings = std::move(made.warnings);
  return input;
}

/// On one rank, which has the whole mesh in its slice.
void keep_whole(SliceInput& input) {
  input.whole = input.slice.boundary;
  input.whole->points = input.slice.points;
  input.whole->point_refs = input.slice.point_refs;
  input.whole->tets = input.slice.tets;
  input.whole->tet_refs = input.slice.tet_refs;
  input.whole_metric = input.slice.log_metrics;
  if (input.target_complexity > 0)
    scale_to_complexity(*input.whole, input.target_complexity, input.whole_metric);
}

/// What is handed out of the whole mesh, as plain bytes.
template <class T>
std::vector<T> deal(Peers& peers, const std::vector<T>& whole, std::uint64_t total) {
  std::vector<std::vector<T>> to_each(static_cast<std::size_t>(peers.ranks()));
  if (peers.rank() == 0)
    for (int r = 0; r < peers.ranks(); ++r) {
      const Share s = share_of(total, r, peers.ranks());
      to_each[static_cast<std::size_t>(r)].assign(
          whole.begin() + static_cast<std::ptrdiff_t>(s.first),
          whole.begin() + static_cast<std::ptrdiff_t>(s.first + s.count));
    }
  return partition::all_to_all(peers, std::move(to_each))[0];
}

/// An array of rank 0, on all ranks.
template <class T>
void tell_all(Peers& peers, std::vector<T>& values) {
  if (peers.rank() > 0) values.clear();
  values = partition::allgather(peers, values)[0];
}

/// The fields that rank 0 has, at the points of the slices.
Fields deal_fields(Peers& peers, const Fields& whole, const MeshSlice& slice) {
  std::vector<Field::Kind> kinds;
  for (const Field& field : whole.fields) kinds.push_back(field.kind);
  tell_all(peers, kinds);
  Fields fields{0, {}};
  for (std::size_t f = 0; f < kinds.size(); ++f) {
    std::vector<char> name;
    if (f < whole.fields.size()) name.assign(whole.fields[f].name.begin(), whole.fields[f].name.end());
    tell_all(peers, name);
    fields.fields.push_back({kinds[f], {}, {name.begin(), name.end()}});
    if (f < whole.fields.size()) fields.fields[f].values = whole.fields[f].values;
  }
  return partition::by_components(fields, slice.points.size(), [&](const std::vector<double>& column) {
    return deal(peers, column, slice.num_points);
  });
}

/// A metric that is only scaled is scaled where all ranks know it, so that its bits do not depend on who has
/// read it.
SliceInput read_whole(Peers& peers, const Files& files, const Options& options,
                      const std::shared_ptr<const meshing::Model>& model) {
  SliceInput input;
  Fields fields;  // whole, on rank 0
  MetricOptions metric = options.metric;
  if (only_scaled(metric)) input.target_complexity = std::exchange(metric.complexity, 0);
  partition::agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    if (!files.background.empty() && files.background != files.input)
      throw InputError(files.background, "", "a background of its own is not possible in subdomains");
    input.whole = meshing::read_mesh(files.input, &input.names);
    if (input.whole->tets.empty()) throw InputError(files.input, "", "has no tetrahedra");
    RepairedMetric repaired;
    fields = read_all_fields(files.fields, input.whole->points.size(), files.input);
    if (options.run.repair) {
      repaired = repair_input(*input.whole, files.input, metric, fields);
      input.mends = std::move(repaired.mends);
    }
    const bool curved = metric.curvature > 0 || metric.sagitta > 0;  // else nobody asks the model here
    LogMetricMade made =
        make_log_metric(metric, *input.whole, files.input, repaired.source ? &*repaired.source : nullptr,
                        curved ? model : nullptr);
    input.whole_metric = std::move(made.field);
    input.warnings = std::move(made.warnings);
  });
  if (peers.ranks() > 1)
    input.warnings.push_back(
        "rank 0 has read the whole mesh: formats other than GMF, binary UGRID and CGNS are not read in "
        "shares, "
        "nor is a mesh repaired in shares");
  input.slice = deal_out(peers, input.whole ? *input.whole : MeshData{}, input.whole_metric);
  input.fields = deal_fields(peers, fields, input.slice);
  if (input.whole && input.target_complexity > 0)
    scale_to_complexity(*input.whole, input.target_complexity, input.whole_metric);
  return input;
}

/// The values of all ranks on rank 0, in their order; elsewhere none.
template <class T>
std::vector<T> concentrate(Peers& peers, const std::vector<T>& mine) {
  std::vector<std::vector<T>> to_each(static_cast<std::size_t>(peers.ranks()));
  to_each[0] = mine;
  return all_to_all_joined(peers, std::move(to_each));
}

}  // namespace

MeshSlice deal_out(Peers& peers, const MeshData& mesh, const meshing::LogMetricField& metric) {
  MeshSlice slice;
  std::vector<std::uint64_t> totals = {mesh.points.size(), mesh.tets.size()};
  tell_all(peers, totals);
  slice.num_points = totals[0];
  slice.num_tets = totals[1];
  slice.first_point = share_of(totals[0], peers.rank(), peers.ranks()).first;
  slice.first_tet = share_of(totals[1], peers.rank(), peers.ranks()).first;
  slice.points = deal(peers, mesh.points, totals[0]);
  slice.point_refs = deal(peers, mesh.point_refs, totals[0]);
  slice.log_metrics = deal(peers, metric, totals[0]);
  slice.tets = deal(peers, mesh.tets, totals[1]);
  slice.tet_refs = deal(peers, mesh.tet_refs, totals[1]);
  MeshData& b = slice.boundary;
  b.triangles = mesh.triangles;
  b.triangle_refs = mesh.triangle_refs;
  b.edges = mesh.edges;
  b.edge_refs = mesh.edge_refs;
  tell_all(peers, b.triangles);
  tell_all(peers, b.triangle_refs);
  tell_all(peers, b.edges);
  tell_all(peers, b.edge_refs);
  const auto list = [&](auto member) {
    b.*member = mesh.*member;
    tell_all(peers, b.*member);
  };
  list(&MeshData::corners);
  list(&MeshData::required_points);
  list(&MeshData::ridges);
  list(&MeshData::required_edges);
  list(&MeshData::required_triangles);
  return slice;
}

SliceInput read_slice(Peers& peers, const Files& files, const Options& options,
                      const std::shared_ptr<const meshing::Model>& model) {
  std::optional<meshing::MeshSize> size;
  if (possible_in_shares(files, options))
    partition::agree_on(peers, [&] { size = meshing::size_for_ranges(files.input); });
  if (!size) return read_whole(peers, files, options, model);
  SliceInput input = read_share(peers, files, options, *size, model);
  if (peers.ranks() == 1) keep_whole(input);
  return input;
}

meshing::MeshData gather_whole(Peers& peers, const MeshSlice& slice) {
  MeshData whole;
  if (peers.rank() == 0) whole = slice.boundary;
  whole.points = concentrate(peers, slice.points);
  whole.point_refs = concentrate(peers, slice.point_refs);
  whole.tets = concentrate(peers, slice.tets);
  whole.tet_refs = concentrate(peers, slice.tet_refs);
  return whole;
}

std::vector<meshing::LogMetric> gather_to_first(Peers& peers, const std::vector<meshing::LogMetric>& mine) {
  return concentrate(peers, mine);
}

std::vector<double> gather_to_first(Peers& peers, const std::vector<double>& mine) {
  return concentrate(peers, mine);
}

Fields gather_to_first(Peers& peers, const Fields& mine) {
  const auto points = partition::sum(peers, std::uint64_t{mine.num_points});
  return partition::by_components(mine, peers.rank() == 0 ? points : 0,
                                  [&](const auto& column) { return concentrate(peers, column); });
}

std::vector<meshing::LogMetric> deal_by_slices(Peers& peers, const std::vector<meshing::LogMetric>& whole,
                                               const MeshSlice& slice) {
  const auto counts = partition::allgather(peers, std::vector<std::uint64_t>{slice.points.size()});
  std::vector<std::vector<meshing::LogMetric>> to_each(counts.size());
  if (peers.rank() == 0) {
    auto next = whole.begin();
    for (std::size_t r = 0; r < counts.size(); ++r) {
      const auto end = next + static_cast<std::ptrdiff_t>(counts[r][0]);
      to_each[r].assign(next, end);
      next = end;
    }
  }
  return partition::all_to_all(peers, std::move(to_each))[0];
}

}  // namespace weft::tools
