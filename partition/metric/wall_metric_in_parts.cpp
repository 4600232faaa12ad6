// Triangles of walls go to the owners of their vertices, which are compact shares already.
#include "partition/metric/wall_metric_in_parts.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/metric/sources/wall_metric.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/communication/triangles_in_shares.h"

namespace weft::partition {
namespace {

using meshing::Point;

struct WallRecord {
  std::uint64_t number;
  std::array<Point, 3> corners;
  std::array<std::uint32_t, 3> vertices;
  std::uint32_t unused = 0;  ///< no byte of a message is undefined
};

/// All ranks: those that have a vertex which this rank owns, in the order of the mesh.
std::vector<WallRecord> walls_at_own_vertices(Peers& peers, const MeshSlice& slice, const PartDomain& domain,
                                              const WallOptions& options) {
  const meshing::MeshData& share = slice.boundary;
  const std::uint64_t first = Ranges(peers, share.triangles.size()).first(peers.rank());
  std::vector<WallRecord> walls;
  std::vector<std::uint32_t> numbers;
  for (std::size_t t = 0; t < share.triangles.size(); ++t)
    if (meshing::is_wall(options, share.triangle_refs[t])) {
      walls.push_back({first + t, {}, share.triangles[t]});
      numbers.insert(numbers.end(), share.triangles[t].begin(), share.triangles[t].end());
    }
  meshing::sort_unique(numbers);
  const std::vector<Point> points = domain.from_slices(slice.points, numbers);
  const std::vector<std::uint32_t> owners = domain.owners_of(numbers);
  std::vector<std::vector<WallRecord>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (WallRecord& wall : walls) {
    std::array<std::uint32_t, 3> ranks;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t place = meshing::place_in(numbers, wall.vertices[i]);
      wall.corners[i] = points[place];
      ranks[i] = owners[place];
    }
    for (std::size_t i = 0; i < 3; ++i)
      if (std::find(ranks.begin(), ranks.begin() + i, ranks[i]) == ranks.begin() + i)
        to_each[ranks[i]].push_back(wall);
  }
  return all_to_all_joined(peers, std::move(to_each));  // ascending: so are slices with the ranks
}

}  // namespace

meshing::LogMetricField wall_metric_in_parts(Peers& peers, const MeshSlice& slice, const PartDomain& domain,
                                             const WallOptions& options) {
  const std::vector<std::int32_t>& refs = slice.boundary.triangle_refs;
  meshing::check_walls(options, [&](std::int32_t ref) {
    return partition::max(peers, int{std::ranges::find(refs, ref) != refs.end()}) != 0;
  });
  std::vector<TrianglesInShares::Triangle> triangles;
  std::vector<meshing::WallDemand::Corner> corners;
  for (const WallRecord& wall : walls_at_own_vertices(peers, slice, domain, options)) {
    triangles.push_back({wall.number, wall.corners});
    meshing::add_corners(wall.vertices, wall.corners, corners);
  }
  const TrianglesInShares walls(peers, std::move(triangles));
  const meshing::WallDemand demand(options, domain.largest_size(), std::move(corners));
  std::vector<std::size_t> away;
  std::vector<Point> points;
  for (std::size_t v = 0; v < domain.numbers().size(); ++v)
    if (domain.owns(v) && !demand.on_wall(domain.numbers()[v])) {
      away.push_back(v);
      points.push_back(domain.mesh().points[v]);
    }
  meshing::LogMetricField field(domain.numbers().size());
  meshing::for_each_index(field.size(), [&](std::size_t v) {
    if (domain.owns(v) && demand.on_wall(domain.numbers()[v]))
      field[v] = demand.at_vertex(domain.numbers()[v]);
  });
  const std::vector<TrianglesInShares::Found> found = walls.closest(points);
  meshing::for_each_index(away.size(), [&](std::size_t i) { field[away[i]] = demand.at_way(found[i].way); });
  domain.refresh(field);
  return field;
}

}  // namespace weft::partition
