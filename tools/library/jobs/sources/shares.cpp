// Ranges of files, and what rank 0 deals out.
#include "tools/library/jobs/sources/shares.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf_slice.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/agreement.h"
#include "partition/communication/even_shares.h"
#include "partition/communication/reduce.h"
#include "partition/fields/by_components.h"
#include "tools/library/jobs/sources/dealt_stream.h"
#include "tools/library/jobs/sources/piece_shares.h"

namespace weft::tools {
namespace {

using meshing::InputError;
using meshing::MeshData;
using partition::MeshSlice;
using partition::Peers;

/// The file's share of this rank.
MeshSlice slice_of_file(const Peers& peers, const std::string& file, const meshing::MeshSize& size,
                        meshing::OtherVolumes others, MeshShare& share) {
  const Share points = share_of(size.points, peers.rank(), peers.ranks());
  const Share tets = share_of(size.tets, peers.rank(), peers.ranks());
  meshing::MeshContents part = meshing::read_mesh_range(
      file,
      {points.first, points.count, tets.first, tets.count, static_cast<std::uint64_t>(peers.rank()),
       static_cast<std::uint64_t>(peers.ranks()), size},
      others);
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
  share.names = std::move(part.names);
  share.dropped = std::move(part.dropped);
  return slice;
}

/// What rank 0 hands out, as plain bytes.
template <class T>
std::vector<T> deal(Peers& peers, const std::vector<T>& whole) {
  std::vector<std::vector<T>> to_each(static_cast<std::size_t>(peers.ranks()));
  if (peers.rank() == 0)
    for (int r = 0; r < peers.ranks(); ++r) {
      const Share s = share_of(whole.size(), r, peers.ranks());
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

bool is_gmf_solution(const std::string& file) {
  const std::string extension = std::filesystem::path(file).extension();
  return extension == ".solb" || extension == ".sol";
}

}  // namespace

Share share_of(std::uint64_t total, int rank, int ranks) {
  const partition::EvenShares shares(total, ranks);
  return {shares.first(rank), shares.count(rank)};
}

bool has_own_fields_in_shares(const std::string& file) {
  return meshing::can_be_in_pieces(file) || meshing::can_stream_fields(file);
}

bool fields_in_shares(const std::string& file) {
  return is_gmf_solution(file) || (meshing::is_mesh_name(file) && has_own_fields_in_shares(file));
}

MeshShare read_mesh_share(Peers& peers, const std::string& file, meshing::OtherVolumes others) {
  MeshShare share;
  std::optional<meshing::MeshSize> size;
  MeshData whole;
  bool streamed = false;
  partition::agree_on(peers, [&] { streamed = peers.rank() == 0 && meshing::can_be_streamed(file); });
  if (partition::max(peers, std::uint8_t{streamed}) != 0) return read_dealt_share(peers, file, others);
  partition::agree_on(peers, [&] {
    size = meshing::size_for_ranges(file);
    if (size) share.slice = slice_of_file(peers, file, *size, others, share);
  });
  if (size) {
    count_boundary(peers, share.slice);
    return share;
  }
  if (meshing::can_be_in_pieces(file)) return PieceShares(peers, file).mesh(peers, others);
  partition::agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    meshing::MeshContents contents = meshing::read_mesh_contents(file);
    if (others == meshing::OtherVolumes::refused)
      meshing::refuse_foreign_volumes(contents.foreign_volumes, file);
    whole = std::move(contents.mesh);
    share.names = std::move(contents.names);
    share.dropped = std::move(contents.dropped);
  });
  share.read_whole = true;
  share.slice = deal_out(peers, whole, {});
  return share;
}

Fields read_fields_share(Peers& peers, const std::string& file, const MeshSlice& slice,
                         const std::function<std::string(std::uint64_t)>& of_another_mesh) {
  const auto check_length = [&](std::uint64_t length) {
    if (length != slice.num_points) throw InputError(file, "", of_another_mesh(length));
  };
  Fields fields;
  if (is_gmf_solution(file)) {
    partition::agree_on(peers, [&] {
      const meshing::GmfLayout layout = meshing::read_gmf_layout(file);
      check_length(layout.num_solution_points());
      fields = meshing::read_gmf_solution_slice(file, layout, slice.first_point, slice.points.size());
    });
    return fields;
  }
  if (fields_in_shares(file)) {
    FieldsShare own = read_own_fields_share(peers, file);
    if (own.fields.fields.empty()) throw InputError(file, "", "holds no fields at vertices");
    check_length(own.num_points);
    return std::move(own.fields);
  }
  partition::agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    fields = meshing::read_solution(file);
    check_length(fields.num_points);
  });
  return deal_fields(peers, fields, slice);
}

FieldsShare read_own_fields_share(Peers& peers, const std::string& file) {
  return meshing::can_stream_fields(file) ? read_dealt_fields(peers, file)
                                          : PieceShares(peers, file).fields(peers);
}

MeshSlice deal_out(Peers& peers, const MeshData& mesh, const meshing::LogMetricField& metric) {
  MeshSlice slice;
  std::vector<std::uint64_t> totals = {mesh.points.size(), mesh.tets.size(), metric.size()};
  tell_all(peers, totals);
  slice.num_points = totals[0];
  slice.num_tets = totals[1];
  slice.first_point = share_of(totals[0], peers.rank(), peers.ranks()).first;
  slice.first_tet = share_of(totals[1], peers.rank(), peers.ranks()).first;
  slice.points = deal(peers, mesh.points);
  slice.point_refs = deal(peers, mesh.point_refs);
  slice.log_metrics = deal(peers, metric);
  slice.tets = deal(peers, mesh.tets);
  slice.tet_refs = deal(peers, mesh.tet_refs);
  deal_boundary(peers, mesh, slice);
  return slice;
}

void deal_boundary(Peers& peers, const MeshData& mesh, MeshSlice& slice) {
  MeshData& b = slice.boundary;
  b.triangles = deal(peers, mesh.triangles);
  b.triangle_refs = deal(peers, mesh.triangle_refs);
  b.edges = deal(peers, mesh.edges);
  b.edge_refs = deal(peers, mesh.edge_refs);
  b.ridges = deal(peers, mesh.ridges);
  b.required_edges = deal(peers, mesh.required_edges);
  b.required_triangles = deal(peers, mesh.required_triangles);
  b.association.nodes = deal(peers, mesh.association.nodes);
  b.association.edges = deal(peers, mesh.association.edges);
  b.association.faces = deal(peers, mesh.association.faces);
  b.corners = deal(peers, mesh.corners);
  b.required_points = deal(peers, mesh.required_points);
  count_boundary(peers, slice);
}

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
  return partition::by_components(fields, slice.points.size(),
                                  [&](const std::vector<double>& column) { return deal(peers, column); });
}

meshing::ContentCounts counts_of_slices(Peers& peers, const MeshSlice& slice) {
  meshing::ContentCounts counts = meshing::counts_of(slice.boundary);
  const std::vector<std::uint64_t> sums = partition::sum(
      peers, std::vector{counts.corners, counts.required_points, counts.ridges, counts.required_edges,
                         counts.required_triangles, counts.on_model, meshing::count_nonzero(slice.point_refs),
                         meshing::count_nonzero(slice.tet_refs)});
  counts.corners = sums[0];
  counts.required_points = sums[1];
  counts.ridges = sums[2];
  counts.required_edges = sums[3];
  counts.required_triangles = sums[4];
  counts.on_model = sums[5];
  counts.point_refs = sums[6];
  counts.tet_refs = sums[7];
  counts.tets = slice.num_tets;
  counts.edges = slice.num_edges;
  return counts;
}

std::string read_whole_warning(const std::string& file, const std::string& what) {
  return "rank 0 has read all of " + file + ": " + what + " of this format are not read in shares";
}

}  // namespace weft::tools
