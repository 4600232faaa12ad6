// Vertices of references, what is joined to them, and the values of the two kinds of coordinate.
#include "partition/coordinate/boundary_coordinate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/base/sort_unique.h"
#include "meshing/geometry/model/closest_tree.h"
#include "meshing/geometry/surface/curved_triangle.h"
#include "meshing/mesh/adjacency.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
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

/// The triangles of the walls with their corners, on every rank.
class Walls {
 public:
  Walls(Peers& peers, const MeshSlice& slice, const BoundaryCoordinate& coordinate) {
    const meshing::MeshData& all = slice.boundary;
    std::vector<std::array<std::uint32_t, 3>> walls;
    for (std::size_t t = 0; t < all.triangles.size(); ++t)
      if (std::ranges::find(coordinate.refs, all.triangle_refs[t]) != coordinate.refs.end())
        walls.push_back(all.triangles[t]);
    walls = allgather_joined(peers, walls);
    const FetchedPoints points(peers, slice, Ranges(peers, slice.points.size()), walls);
    std::vector<meshing::ClosestForest::Item> items(walls.size());
    for (std::uint32_t t = 0; t < items.size(); ++t) {
      items[t].id = t;
      triangles_.push_back(points.of(walls[t]));
      for (const Point& corner : triangles_[t]) items[t].box.include(corner);
    }
    root_ = forest_.add(items);
  }

  double distance(const Point& p) const {
    const auto distance2 = [&](std::uint32_t t) {
      const auto& [a, b, c] = triangles_[t];
      return meshing::closest_point(a, b, c, p).distance2;
    };
    return std::sqrt(distance2(forest_.closest(root_, p, distance2)));
  }

 private:
  std::vector<std::array<Point, 3>> triangles_;
  meshing::ClosestForest forest_;
  std::uint32_t root_ = 0;
};

CoordinateValues distance_from_wall(Peers& peers, const MeshSlice& slice,
                                    const BoundaryCoordinate& coordinate) {
  check_slices(peers, slice, Ranges(peers, slice.points.size()), Ranges(peers, slice.tets.size()),
               SliceMetric::missing);
  const Walls walls(peers, slice, coordinate);
  CoordinateValues result{std::vector<double>(slice.points.size())};
  meshing::for_each_index(slice.points.size(),
                          [&](std::size_t v) { result.values[v] = walls.distance(slice.points[v]); });
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
