// Slices have their places already.
#include "partition/fields/slice_files.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/place_in.h"
#include "meshing/io/files/single_precision.h"
#include "meshing/io/gmf/gmf_slice_writer.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/agreement.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/output/common_blocks.h"
#include "partition/output/common_file.h"
#include "partition/output/common_text.h"
#include "partition/output/gmf_output.h"
#include "partition/slice/fetched_points.h"

namespace weft::partition {
namespace {

using meshing::GmfPlan;
using meshing::GmfSliceWriter;
using meshing::MeshData;
using meshing::RefCounts;
using meshing::WholeMesh;

template <std::size_t N>
std::vector<std::array<std::uint64_t, N>> rows_of(const std::vector<std::array<std::uint32_t, N>>& elements) {
  std::vector<std::array<std::uint64_t, N>> rows;
  rows.reserve(elements.size());
  for (const auto& element : elements) {
    std::array<std::uint64_t, N>& row = rows.emplace_back();
    std::copy(element.begin(), element.end(), row.begin());
  }
  return rows;
}

std::vector<std::uint64_t> wide(const std::vector<std::uint32_t>& list) { return {list.begin(), list.end()}; }

/// What this rank writes of the mesh.
struct Rows {
  std::vector<std::array<std::uint64_t, 4>> tets;
  std::vector<std::array<std::uint64_t, 3>> triangles;
  std::vector<std::array<std::uint64_t, 2>> edges;

  explicit Rows(const MeshSlice& slice)
      : tets(rows_of(slice.tets)),
        triangles(rows_of(slice.boundary.triangles)),
        edges(rows_of(slice.boundary.edges)) {}
};

/// Where this rank's shares of the lists of marks are among all.
struct MarkRanges {
  Ranges corners, points, ridges, edges, triangles;
};

/// All ranks.
MarkRanges mark_ranges(Peers& peers, const MeshData& b) {
  const std::vector<Ranges> r =
      Ranges::of_arrays(peers, {b.corners.size(), b.required_points.size(), b.ridges.size(),
                                b.required_edges.size(), b.required_triangles.size()});
  return {r[0], r[1], r[2], r[3], r[4]};
}

GmfPlan gmf_plan(const MeshSlice& slice, const MarkRanges& marks, const std::filesystem::path& file) {
  return GmfPlan::of_mesh(file, {.points = slice.num_points,
                                 .edges = slice.num_edges,
                                 .triangles = slice.num_triangles,
                                 .tets = slice.num_tets,
                                 .corners = marks.corners.total(),
                                 .ridges = marks.ridges.total(),
                                 .required_points = marks.points.total(),
                                 .required_edges = marks.edges.total(),
                                 .required_triangles = marks.triangles.total()});
}

/// All ranks: it appears when all have written.
template <class Output, class Write>
void write_together(Peers& peers, Output& common, const Write& write) {
  agree_on(peers, write);
  common.deliver(peers);
  agree_on(peers, [&] {
    if (peers.rank() == 0) common.commit();
  });
}

/// What this rank writes of a GMF file.
void write_gmf(const MeshSlice& slice, const MarkRanges& marks, int rank, GmfSliceWriter& out) {
  namespace gmf = meshing::gmf;
  const Rows rows(slice);
  const MeshData& b = slice.boundary;
  out.vertices(slice.first_point, slice.points, slice.point_refs);
  out.elements(gmf::kEdges, slice.first_edge, rows.edges, b.edge_refs);
  out.elements(gmf::kTriangles, slice.first_triangle, rows.triangles, b.triangle_refs);
  out.elements(gmf::kTetrahedra, slice.first_tet, rows.tets, slice.tet_refs);
  out.indices(gmf::kCorners, marks.corners.first(rank), wide(b.corners));
  out.indices(gmf::kRequiredVertices, marks.points.first(rank), wide(b.required_points));
  out.indices(gmf::kRidges, marks.ridges.first(rank), wide(b.ridges));
  out.indices(gmf::kRequiredEdges, marks.edges.first(rank), wide(b.required_edges));
  out.indices(gmf::kRequiredTriangles, marks.triangles.first(rank), wide(b.required_triangles));
}

/// All ranks: a GMF file, of which write(out) writes this rank's rows.
template <class Write>
void write_as_gmf(Peers& peers, const std::filesystem::path& file, const GmfPlan& plan, const Write& write) {
  GmfOutput output(file, plan, {{static_cast<std::uint64_t>(peers.rank()), write}});
  output.create(peers);
  write_together(peers, output, [&] { output.write(); });
}

/// All ranks: how many elements of all have each reference; `lower`: of those in front of this rank's.
RefCounts count_refs(Peers& peers, const std::vector<std::int32_t>& refs, RefCounts& lower) {
  struct Row {
    std::uint64_t count;
    std::int64_t ref;
  };
  std::vector<Row> mine;
  for (const auto& [ref, count] : meshing::count_refs(refs)) mine.push_back({count, ref});
  RefCounts all;
  const auto of_ranks = partition::allgather(peers, mine);
  for (std::size_t r = 0; r < of_ranks.size(); ++r) {
    if (r == static_cast<std::size_t>(peers.rank())) lower = all;
    for (const Row& row : of_ranks[r]) all[static_cast<std::int32_t>(row.ref)] += row.count;
  }
  for (const auto& [ref, count] : all) lower.try_emplace(ref, 0);
  return all;
}

/// Of the elements of lower ranks, how many have each reference.
struct FirstRows {
  RefCounts tets, triangles, edges;
};

/// All ranks: all corners with their points, which their owners have.
std::vector<WholeMesh::Corner> corners_of(Peers& peers, const MeshSlice& slice) {
  const Ranges points(peers, slice.points.size());
  const std::vector<std::uint32_t> all = allgather_joined(peers, slice.boundary.corners);
  std::vector<std::uint32_t> numbers = all;
  std::ranges::sort(numbers);
  struct Place {
    meshing::Point point;
    std::int64_t ref;
  };
  const auto places = fetch<Place>(peers, points, numbers, [&](std::size_t i) {
    return Place{slice.points[i], slice.point_refs[i]};
  });
  std::vector<WholeMesh::Corner> corners;
  for (const std::uint32_t v : all) {
    const Place& at = places[meshing::place_in(numbers, v)];
    corners.push_back({v, at.point, static_cast<std::int32_t>(at.ref)});
  }
  return corners;
}

/// All ranks: as meshing::describe() does of the whole mesh.
WholeMesh describe_slices(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                          const meshing::RefNames& names, FirstRows& first) {
  WholeMesh whole;
  whole.points = whole.fields.num_points = slice.num_points;
  whole.tets = count_refs(peers, slice.tet_refs, first.tets);
  whole.triangles = count_refs(peers, slice.boundary.triangle_refs, first.triangles);
  whole.edges = count_refs(peers, slice.boundary.edge_refs, first.edges);
  whole.corners = corners_of(peers, slice);
  const bool refs = std::ranges::any_of(slice.point_refs, [](std::int32_t ref) { return ref != 0; });
  whole.point_refs = partition::max(peers, static_cast<int>(refs)) != 0;
  meshing::Box mine;
  for (const meshing::Point& p : slice.points) mine.include(p);
  if (slice.num_points > 0) {
    const meshing::Box box = common_box(peers, mine);
    whole.low = box.lo;
    whole.high = box.hi;
  }
  if (peers.rank() == 0) whole.names = names;
  for (const meshing::Field& field : fields.fields)
    whole.fields.fields.push_back({field.kind, {}, field.name});
  return whole;
}

/// action(this rank's part of the mesh).
template <class Action>
void with_part(const MeshSlice& slice, const meshing::SolutionData& fields, const FirstRows& first,
               const Action& action) {
  const Rows rows(slice);
  const MeshData& b = slice.boundary;
  action(meshing::MeshPart{slice.first_point,
                           slice.points,
                           slice.point_refs,
                           {rows.tets, slice.tet_refs, slice.first_tet, first.tets},
                           {rows.triangles, b.triangle_refs, slice.first_triangle, first.triangles},
                           {rows.edges, b.edge_refs, slice.first_edge, first.edges},
                           fields});
}

/// All ranks: throws where the reals of such a file would break the mesh.
void refuse_rounding(Peers& peers, const MeshSlice& slice, const std::filesystem::path& file) {
  if (!meshing::has_short_reals(file)) return;
  const FetchedPoints points(peers, slice, Ranges(peers, slice.points.size()), slice.tets);
  agree_on(peers, [&] {
    meshing::refuse_if_rounding_breaks(
        slice.points, slice.first_point, slice.tets.size(), slice.first_tet,
        [&](std::size_t t) { return points.of(slice.tets[t]); }, file.string());
  });
}

void write_in_parts(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                    const WholeMesh& whole, const FirstRows& first, const std::filesystem::path& file) {
  refuse_rounding(peers, slice, file);
  CommonFile common(file);
  common.create(peers);
  meshing::PartPlaces places;
  agree_on(peers, [&] {
    if (peers.rank() == 0) places = meshing::begin_parts(common.temporary(), common.name(), whole);
  });
  places = allgather(peers, places)[0];
  write_together(peers, common, [&] {
    const auto out = meshing::open_part(common.target(), whole, places);
    with_part(slice, fields, first, [&](const meshing::MeshPart& part) { out->write(part); });
    out->finish();
  });
}

}  // namespace

void write_fields_of_slices(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                            const std::filesystem::path& file) {
  std::vector<meshing::Field::Kind> kinds;
  for (const meshing::Field& field : fields.fields) kinds.push_back(field.kind);
  std::optional<GmfPlan> plan;
  agree_on(peers, [&] { plan = GmfPlan::of_solution(file, slice.num_points, kinds); });
  write_as_gmf(peers, file, *plan, [&](GmfSliceWriter& out) { out.solution(slice.first_point, fields); });
}

bool can_write_slices(const std::filesystem::path& mesh, const meshing::WriteOptions& options) {
  return meshing::gmf::is_mesh(mesh) || meshing::can_be_written_in_parts(mesh, options) ||
         meshing::can_be_written_as_text(mesh, options) || meshing::can_be_written_in_blocks(mesh, options);
}

void write_mesh_of_slices(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                          const meshing::RefNames& names, const std::filesystem::path& file,
                          const meshing::WriteOptions& options) {
  if (meshing::gmf::is_mesh(file)) {
    const MarkRanges marks = mark_ranges(peers, slice.boundary);
    std::optional<GmfPlan> plan;
    agree_on(peers, [&] { plan = gmf_plan(slice, marks, file); });
    return write_as_gmf(peers, file, *plan,
                        [&](GmfSliceWriter& out) { write_gmf(slice, marks, peers.rank(), out); });
  }
  const meshing::SolutionData none;
  const meshing::SolutionData& inside = meshing::holds_fields(file) ? fields : none;
  FirstRows first;
  WholeMesh whole = describe_slices(peers, slice, inside, names, first);
  whole.options = options;
  const auto for_parts = [&](const PartAction& action) {
    with_part(slice, inside, first,
              [&](const meshing::MeshPart& part) { action(static_cast<std::uint64_t>(peers.rank()), part); });
  };
  const auto write_as = [&](auto&& common) {
    common.create(peers);
    write_together(peers, common, [&] { common.write(); });
  };
  if (meshing::can_be_written_as_text(file, options))
    write_as(CommonText(file, whole, for_parts));
  else if (meshing::can_be_written_in_blocks(file, options))
    write_as(CommonBlocks(file, whole, for_parts));
  else
    write_in_parts(peers, slice, inside, whole, first, file);
}

}  // namespace weft::partition
