// Vertices of references, what is joined to them, and the values of the two kinds of coordinate.
#include "partition/coordinate/boundary_coordinate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/base/sort_unique.h"
#include "meshing/mesh/adjacency.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/communication/triangles_in_shares.h"
#include "partition/coordinate/harmonic_solver.h"
#include "partition/metric/part_domain.h"
#include "partition/slice/fetched_points.h"
#include "partition/slice/slice_checks.h"

namespace weft::partition {
namespace {

using meshing::Point;

/// All ranks throw alike.
void check_references(Peers& peers, const MeshSlice& slice, const BoundaryCoordinate& coordinate) {
  const std::vector<std::int32_t>& refs = slice.boundary.triangle_refs;
  for (const std::int32_t ref : coordinate.refs)
    if (partition::max(peers, int{std::ranges::find(refs, ref) != refs.end()}) == 0)
      throw meshing::InputError("", "partitioner " + text_of(coordinate),
                                fmt::format("no triangle has the reference {}", ref));
}

/// All ranks: marks the vertices of the part that triangles of this reference have.
std::vector<std::uint8_t> vertices_of_reference(Peers& peers, const MeshSlice& slice, std::int32_t ref,
                                                const PartDomain& domain) {
  const Ranges points(peers, slice.points.size());
  std::vector<std::uint32_t> numbers;
  for (std::size_t t = 0; t < slice.boundary.triangles.size(); ++t)
    if (slice.boundary.triangle_refs[t] == ref)
      numbers.insert(numbers.end(), slice.boundary.triangles[t].begin(), slice.boundary.triangles[t].end());
  meshing::sort_unique(numbers);
  std::vector<std::uint8_t> marks(slice.points.size(), 0);
  for (const auto& of_rank : sent_to_owners(peers, points, numbers))
    for (const std::uint32_t number : of_rank) marks[number - slice.first_point] = 1;
  return domain.from_slices(marks);
}

/// Marks spread along edges through the whole mesh: within a part at once, to the next ones in rounds. An
/// owner has all edges at its vertices, so that only owned ones need be marked here.
void flood(const PartDomain& domain, const meshing::VertexLists& neighbours,
           std::vector<std::uint8_t>& marks) {
  std::vector<std::uint8_t> spread(marks.size(), 0);
  for (bool more = true; more;) {
    std::vector<std::uint32_t> front;
    for (std::uint32_t v = 0; v < marks.size(); ++v)
      if (marks[v] && !spread[v]) front.push_back(v);
    more = domain.any(!front.empty());
    while (!front.empty()) {
      const std::uint32_t v = front.back();
      front.pop_back();
      spread[v] = 1;
      for (const std::uint32_t w : neighbours.of(v))
        if (!marks[w] && domain.owns(w)) {
          marks[w] = 1;
          front.push_back(w);
        }
    }
    domain.refresh(marks);
  }
}

/// All vertices of tets must be joined to the reference by tets.
void check_joined(Peers& peers, const PartDomain& domain, const meshing::VertexLists& neighbours,
                  std::vector<std::uint8_t> marks, const BoundaryCoordinate& coordinate, std::int32_t ref) {
  flood(domain, neighbours, marks);
  std::uint64_t apart = 0;
  for (std::size_t v = 0; v < marks.size(); ++v)
    apart += domain.owns(v) && !marks[v] && !neighbours.of(v).empty();
  apart = partition::sum(peers, apart);
  if (apart > 0)
    throw meshing::InputError(
        "", "partitioner " + text_of(coordinate),
        fmt::format("{} vertices are in parts of the mesh that tets do not join to reference {}", apart,
                    ref));
}

CoordinateValues harmonic(Peers& peers, const MeshSlice& slice, const BoundaryCoordinate& coordinate) {
  constexpr double kTolerance = 1e-6;
  constexpr int kMostSteps = 3000;
  const PartDomain domain(peers, slice, 1);
  std::array<std::vector<std::uint8_t>, 2> ends;
  {
    const auto neighbours = meshing::vertex_neighbours(domain.mesh().tets, domain.mesh().points.size());
    for (std::size_t i = 0; i < 2; ++i) {
      ends[i] = vertices_of_reference(peers, slice, coordinate.refs[i], domain);
      check_joined(peers, domain, neighbours, ends[i], coordinate, coordinate.refs[i]);
    }
  }
  std::vector<double> values(ends[0].size(), 0.5);
  std::vector<std::uint8_t> fixed(values.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    fixed[v] = ends[0][v] | ends[1][v];
    values[v] += 0.5 * (ends[1][v] - ends[0][v]);
  }
  const Solved solved = solve_harmonic(domain, fixed, kTolerance, kMostSteps, values);
  CoordinateValues result{domain.to_slices(values)};
  if (solved.reduction > kTolerance)
    result.warning = fmt::format(
        "slabs along {}: the equation is solved to {:.1e} of its first residual, not {:.0e}, after {} steps",
        text_of(coordinate), solved.reduction, kTolerance, solved.steps);
  return result;
}

/// All ranks: the triangles of the walls, an equal share of those that lie together on each.
std::vector<TrianglesInShares::Triangle> dealt_walls(Peers& peers, const MeshSlice& slice,
                                                     const BoundaryCoordinate& coordinate) {
  const meshing::MeshData& share = slice.boundary;
  const std::uint64_t first = Ranges(peers, share.triangles.size()).first(peers.rank());
  std::vector<std::array<std::uint32_t, 3>> walls;
  std::vector<TrianglesInShares::Triangle> triangles;
  for (std::size_t t = 0; t < share.triangles.size(); ++t)
    if (std::ranges::find(coordinate.refs, share.triangle_refs[t]) != coordinate.refs.end()) {
      walls.push_back(share.triangles[t]);
      triangles.push_back({first + t, {}});
    }
  const FetchedPoints points(peers, slice, Ranges(peers, slice.points.size()), walls);
  std::vector<Point> places;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    triangles[i].corners = points.of(walls[i]);
    places.push_back(triangles[i].corners[0]);
  }
  const std::vector<std::uint32_t> owners = morton_shares(peers, {places}).owners(places);
  std::vector<std::vector<TrianglesInShares::Triangle>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t i = 0; i < owners.size(); ++i) to_each[owners[i]].push_back(triangles[i]);
  return all_to_all_joined(peers, std::move(to_each));
}

CoordinateValues distance_from_wall(Peers& peers, const MeshSlice& slice,
                                    const BoundaryCoordinate& coordinate) {
  check_slices(peers, slice, Ranges(peers, slice.points.size()), Ranges(peers, slice.tets.size()),
               SliceMetric::missing);
  const TrianglesInShares walls(peers, dealt_walls(peers, slice, coordinate));
  CoordinateValues result;
  result.values.reserve(slice.points.size());
  for (const TrianglesInShares::Found& found : walls.closest(slice.points))
    result.values.push_back(std::sqrt(found.distance2));
  return result;
}

}  // namespace

CoordinateValues boundary_coordinate(Peers& peers, const MeshSlice& slice,
                                     const BoundaryCoordinate& coordinate) {
  check_references(peers, slice, coordinate);
  if (coordinate.kind == BoundaryCoordinate::Kind::wall) return distance_from_wall(peers, slice, coordinate);
  return harmonic(peers, slice, coordinate);
}

}  // namespace weft::partition
