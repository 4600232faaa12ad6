// The checks of meshing::import_mesh, on a share of the arrays.
#include "partition/slice/slice_checks.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "meshing/mesh/predicates.h"
#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using meshing::MeshData;

/// Issues come in this order.
enum Stage : std::uint64_t {
  kSizes,
  kPoints,
  kMetrics,
  kTets,
  kTriangles,
  kEdges,
  kCorners,
  kRequiredPoints,
  kRidges,
  kRequiredEdges,
  kRequiredTriangles,
  kNoTets
};

class Checks {
 public:
  explicit Checks(std::uint64_t num_points) : num_points_(num_points) {}
  const std::optional<InputIssue>& first() const { return first_; }

  void size(const char* what, std::uint64_t refs, std::uint64_t entities) {
    if (refs != entities)
      add(kSizes, fmt::format("{}", what), fmt::format("{} references for {} entities", refs, entities));
  }

  /// Vertex 0 of a file that counts from 1 is the greatest number here, and named 0 again.
  template <std::size_t N>
  void vertices(Stage stage, const char* what, std::uint64_t first,
                const std::vector<std::array<std::uint32_t, N>>& entities) {
    for (std::size_t i = 0; i < entities.size(); ++i)
      for (const std::uint32_t v : entities[i])
        if (v >= num_points_)
          return add(stage, fmt::format("{} {}", what, first + i + 1),
                     fmt::format("vertex {} is out of range 1..{}", v + 1, num_points_), first + i);
  }

  void list(Stage stage, const char* what, const char* of, std::uint64_t first,
            const std::vector<std::uint32_t>& list, std::uint64_t count) {
    for (std::size_t i = 0; i < list.size(); ++i)
      if (list[i] >= count)
        return add(stage, fmt::format("{} {}", what, first + i + 1),
                   fmt::format("{} {} is out of range 1..{}", of, list[i] + 1, count), first + i);
  }

  void finite(std::uint64_t first, const std::vector<meshing::Point>& points) {
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!std::isfinite(points[i].x + points[i].y + points[i].z))
        return add(kPoints, fmt::format("vertex {}", first + i + 1), "has a coordinate that is not finite",
                   first + i);
  }

  /// The density of the wanted mesh must be a number.
  void densities(std::uint64_t first, const meshing::LogMetricField& log_metrics) {
    for (std::size_t i = 0; i < log_metrics.size(); ++i)
      if (!std::isfinite(std::exp(0.5 * trace(log_metrics[i]))))
        return add(kMetrics, fmt::format("vertex {}", first + i + 1), "has a metric that is not finite",
                   first + i);
  }

  /// Issues of one stage and number keep the order in which they were added.
  void add(Stage stage, std::string entity, std::string reason, std::uint64_t number = 0) {
    keep_least(first_, {{stage, number, added_++}, std::move(entity), std::move(reason)});
  }

 private:
  std::uint64_t num_points_, added_ = 0;
  std::optional<InputIssue> first_;
};

/// All ranks: where everything lies.
struct SliceRanges {
  Ranges triangles, edges, corners, required_points, ridges, required_edges, required_triangles;
};

SliceRanges ranges_of(Peers& peers, const MeshData& m) {
  const std::vector<Ranges> r = Ranges::of_arrays(
      peers, {m.triangles.size(), m.edges.size(), m.corners.size(), m.required_points.size(), m.ridges.size(),
              m.required_edges.size(), m.required_triangles.size()});
  return {r[0], r[1], r[2], r[3], r[4], r[5], r[6]};
}

/// Sizes of the whole mesh where they do not fit, else those of this rank. `all_refs`: of all ranks.
void check_sizes(const MeshSlice& slice, const std::vector<std::uint64_t>& refs,
                 const std::vector<std::uint64_t>& all_refs, Checks& checks) {
  const MeshData& m = slice.boundary;
  const std::vector<std::uint64_t> here = {slice.points.size(), slice.tets.size(), m.triangles.size(),
                                           m.edges.size()};
  const std::vector<std::uint64_t> all = {slice.num_points, slice.num_tets, slice.num_triangles,
                                          slice.num_edges};
  const char* const names[] = {"vertices", "tets", "triangles", "edges"};
  for (std::size_t i = 0; i < all.size(); ++i)
    all_refs[i] != all[i] ? checks.size(names[i], all_refs[i], all[i])
                          : checks.size(names[i], refs[i], here[i]);
}

void check_boundary(int rank, const MeshSlice& slice, const SliceRanges& ranges, Checks& checks) {
  const MeshData& m = slice.boundary;
  checks.vertices(kTriangles, "triangle", slice.first_triangle, m.triangles);
  checks.vertices(kEdges, "edge", slice.first_edge, m.edges);
  checks.list(kCorners, "corner", "vertex", ranges.corners.first(rank), m.corners, slice.num_points);
  checks.list(kRequiredPoints, "required vertex", "vertex", ranges.required_points.first(rank),
              m.required_points, slice.num_points);
  checks.list(kRidges, "ridge", "edge", ranges.ridges.first(rank), m.ridges, slice.num_edges);
  checks.list(kRequiredEdges, "required edge", "edge", ranges.required_edges.first(rank), m.required_edges,
              slice.num_edges);
  checks.list(kRequiredTriangles, "required triangle", "triangle", ranges.required_triangles.first(rank),
              m.required_triangles, slice.num_triangles);
}

/// Whether this rank's share is where it says.
bool share_fits(int rank, const MeshSlice& slice, const Ranges& points, const Ranges& tets,
                const SliceRanges& boundary, SliceMetric metric) {
  const auto fits = [&](const Ranges& ranges, std::uint64_t total, std::uint64_t first) {
    return ranges.total() == total && ranges.first(rank) == first;
  };
  return fits(points, slice.num_points, slice.first_point) && fits(tets, slice.num_tets, slice.first_tet) &&
         fits(boundary.triangles, slice.num_triangles, slice.first_triangle) &&
         fits(boundary.edges, slice.num_edges, slice.first_edge) &&
         (slice.log_metrics.size() == slice.points.size() ||
          (metric == SliceMetric::missing && slice.log_metrics.empty()));
}

}  // namespace

void check_slices(Peers& peers, const MeshSlice& slice, const Ranges& points, const Ranges& tets,
                  SliceMetric metric) {
  const MeshData& m = slice.boundary;
  const SliceRanges boundary = ranges_of(peers, m);
  const std::vector<std::uint64_t> refs = {slice.point_refs.size(), slice.tet_refs.size(),
                                           m.triangle_refs.size(), m.edge_refs.size()};
  std::vector<std::uint64_t> told = refs;
  told.push_back(share_fits(peers.rank(), slice, points, tets, boundary, metric) ? 0 : 1);
  told = partition::sum(peers, told);
  if (told.back() > 0) throw std::invalid_argument("the ranks' shares do not make up the mesh");
  Checks checks(slice.num_points);
  check_sizes(slice, refs, told, checks);
  checks.finite(slice.first_point, slice.points);
  checks.densities(slice.first_point, slice.log_metrics);
  checks.vertices(kTets, "tet", slice.first_tet, slice.tets);
  check_boundary(peers.rank(), slice, boundary, checks);
  if (slice.num_tets == 0) checks.add(kNoTets, "Tetrahedra", "the mesh has none");
  throw_first(peers, checks.first());
}

std::optional<InputIssue> inverted(std::uint64_t number, const std::array<std::uint32_t, 4>& vertices,
                                   const std::array<const meshing::Point*, 4>& corners) {
  const auto& [a, b, c, d] = corners;
  const int sign = meshing::orientation(*a, *b, *c, *d);
  if (sign > 0) return {};
  const auto vertex = [&](std::size_t i) { return std::uint64_t{vertices[i]} + 1; };
  return InputIssue{
      {number, 0, 0},
      fmt::format("tet {} ({} {} {} {})", number + 1, vertex(0), vertex(1), vertex(2), vertex(3)),
      sign < 0 ? "is inverted (negative volume)" : "is flat (exactly zero volume)"};
}

}  // namespace weft::partition
