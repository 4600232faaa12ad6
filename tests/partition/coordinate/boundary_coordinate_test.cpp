// Coordinates along the boundary: against exact ones, the same bits on all ranks, and what is refused.
#include "partition/coordinate/boundary_coordinate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "meshing/base/error.h"
#include "partition/decompose/partitioner.h"
#include "partition/distribute/distribute.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/metric_meshes.h"

namespace weft::partition {
namespace {

using meshing::MeshData;
using meshing::Point;
using ::testing::HasSubstr;

/// A quarter of a ring, 1 to 2 from its axis: references 1 and 2 are its ends at 0 and 90 degrees, 3 the
/// inner side and 4 the outer one.
MeshData bend(std::uint32_t cells, unsigned seed) {
  MeshData mesh = support::unit_cube(cells);
  support::jitter_interior(mesh, 0.1 / cells, seed);
  for (Point& p : mesh.points) {
    const double angle = p.x * std::numbers::pi / 2, radius = 1 + p.y;
    p = {radius * std::cos(angle), -radius * std::sin(angle), p.z};
  }
  support::shuffle(mesh, seed);
  return mesh;
}

double angle_of(const Point& p) { return std::atan2(-p.y, p.x) / (std::numbers::pi / 2); }
double radius_of(const Point& p) { return std::hypot(p.x, p.y); }

/// At the points of the whole mesh, shares by `seed`.
std::vector<double> coordinate_on(int ranks, unsigned seed, const MeshData& mesh, const std::string& name) {
  const support::MetricMesh whole{mesh, meshing::LogMetricField(mesh.points.size())};
  std::vector<std::vector<double>> of_rank(static_cast<std::size_t>(ranks));
  support::run_ranks(ranks, [&](Peers& peers) {
    CoordinateValues found = boundary_coordinate(peers, support::slice_of(whole, peers.rank(), ranks, seed),
                                                 parse_coordinate(name));
    EXPECT_EQ(found.warning, "");
    of_rank[static_cast<std::size_t>(peers.rank())] = std::move(found.values);
  });
  std::vector<double> all;
  for (const auto& values : of_rank) all.insert(all.end(), values.begin(), values.end());
  return all;
}

double largest_error(const MeshData& mesh, const std::vector<double>& values,
                     const std::function<double(const Point&)>& exact) {
  EXPECT_EQ(values.size(), mesh.points.size());
  double error = 0;
  for (std::size_t v = 0; v < values.size(); ++v)
    error = std::max(error, std::abs(values[v] - exact(mesh.points[v])));
  return error;
}

TEST(BoundaryCoordinate, LinearFunctionsAreHarmonicOnAnyMesh) {
  MeshData mesh = support::unit_cube(6);
  support::jitter_interior(mesh, 0.02, 5);
  support::shuffle(mesh, 5);
  EXPECT_LT(
      largest_error(mesh, coordinate_on(2, 0, mesh, "harmonic=1,2"), [](const Point& p) { return p.x; }),
      1e-5);
  EXPECT_LT(
      largest_error(mesh, coordinate_on(2, 0, mesh, "harmonic=6,5"), [](const Point& p) { return 1 - p.z; }),
      1e-5);
}

TEST(BoundaryCoordinate, FollowsABendBetterTheFinerTheMesh) {
  const auto angle_error = [](std::uint32_t cells) {
    const MeshData mesh = bend(cells, 3);
    return largest_error(mesh, coordinate_on(1, 0, mesh, "harmonic=1,2"), angle_of);
  };
  const auto radius_error = [](std::uint32_t cells) {
    const MeshData mesh = bend(cells, 3);
    return largest_error(mesh, coordinate_on(1, 0, mesh, "harmonic=3,4"),
                         [](const Point& p) { return std::log(radius_of(p)) / std::log(2.0); });
  };
  EXPECT_LT(angle_error(4), 0.02);
  EXPECT_LT(angle_error(12), 0.4 * angle_error(4));
  EXPECT_LT(radius_error(4), 0.03);
  EXPECT_LT(radius_error(12), 0.4 * radius_error(4));
}

TEST(BoundaryCoordinate, WhereBothReferencesMeetItIsHalf) {
  const MeshData mesh = support::unit_cube(3);  // sides 1 and 3 have an edge in common
  const std::vector<double> values = coordinate_on(1, 0, mesh, "harmonic=1,3");
  for (std::size_t v = 0; v < values.size(); ++v) {
    const auto& [x, y, z] = mesh.points[v];
    if (x == 0) {
      EXPECT_EQ(values[v], y == 0 ? 0.5 : 0) << y;
    } else if (y == 0) {
      EXPECT_EQ(values[v], 1) << x;
    }
  }
}

TEST(BoundaryCoordinate, WallsAreAsFarAsTheNearestOfTheirTriangles) {
  MeshData mesh = support::unit_cube(4);
  support::shuffle(mesh, 2);
  EXPECT_LT(largest_error(mesh, coordinate_on(2, 3, mesh, "wall=3"), [](const Point& p) { return p.y; }),
            1e-15);
  EXPECT_LT(largest_error(mesh, coordinate_on(2, 3, mesh, "wall=2,5"),
                          [](const Point& p) { return std::min(1 - p.x, p.z); }),
            1e-15);
  const MeshData ring = bend(6, 2);  // triangles are chords of the inner side
  EXPECT_LT(largest_error(ring, coordinate_on(1, 0, ring, "wall=3"),
                          [](const Point& p) { return radius_of(p) - 1; }),
            0.02);
}

TEST(BoundaryCoordinate, HasTheSameBitsOnAnyRanksAndShares) {
  const MeshData mesh = bend(5, 7);
  for (const char* name : {"harmonic=1,2", "harmonic=3,4", "wall=3", "wall=1,2,3,4,5,6"}) {
    const std::vector<double> expected = coordinate_on(1, 0, mesh, name);
    for (const int ranks : support::kNumbersOfRanks)
      for (const unsigned seed : {0u, 4u, 5u})
        ASSERT_EQ(coordinate_on(ranks, seed, mesh, name), expected) << name;
  }
}

std::string refusal(int ranks, const MeshData& mesh, const std::string& name) {
  const support::MetricMesh whole{mesh, meshing::LogMetricField(mesh.points.size())};
  std::vector<std::string> said(static_cast<std::size_t>(ranks));
  support::run_ranks(ranks, [&](Peers& peers) {
    try {
      boundary_coordinate(peers, support::slice_of(whole, peers.rank(), ranks), parse_coordinate(name));
    } catch (const meshing::InputError& error) {
      said[static_cast<std::size_t>(peers.rank())] = error.what();
    }
  });
  EXPECT_THAT(said, ::testing::Each(said[0])) << "ranks say different things";
  return said[0];
}

TEST(BoundaryCoordinate, SaysWhatIsWrongOnAllRanks) {
  const MeshData cube = support::unit_cube(3);
  EXPECT_THAT(refusal(3, cube, "harmonic=1,9"), HasSubstr("harmonic=1,9: no triangle has the reference 9"));
  EXPECT_THAT(refusal(3, cube, "wall=-4"), HasSubstr("wall=-4: no triangle has the reference -4"));
  EXPECT_EQ(refusal(3, cube, "harmonic=1,4"), "");

  // A second cube beside the first, whose sides have the references 11 to 16.
  MeshData both = cube;
  const auto first = static_cast<std::uint32_t>(both.points.size());
  for (const Point& p : cube.points) both.points.push_back({p.x + 3, p.y, p.z}), both.point_refs.push_back(0);
  for (auto tet : cube.tets) {
    for (std::uint32_t& v : tet) v += first;
    both.tets.push_back(tet), both.tet_refs.push_back(1);
  }
  for (std::size_t t = 0; t < cube.triangles.size(); ++t) {
    auto triangle = cube.triangles[t];
    for (std::uint32_t& v : triangle) v += first;
    both.triangles.push_back(triangle), both.triangle_refs.push_back(10 + cube.triangle_refs[t]);
  }
  for (const int ranks : {1, 3}) {
    EXPECT_THAT(refusal(ranks, both, "harmonic=1,12"),
                HasSubstr("64 vertices are in parts of the mesh that tets do not join to reference 1"));
    EXPECT_EQ(refusal(ranks, both, "wall=1"), "");
  }
}

/// What distribute() makes of slabs along a coordinate: pieces in order of the exact coordinate, by middles
/// of tets, up to a tet's size.
void expect_in_order(const std::string& partitioner, const std::function<double(const Point&)>& exact,
                     double size) {
  constexpr std::uint32_t kSlabs = 4;
  const MeshData mesh = bend(8, 4);
  const support::MetricMesh whole{mesh, meshing::LogMetricField(mesh.points.size(), meshing::LogMetric{})};
  std::vector<std::array<double, 2>> reach(kSlabs, {1e9, -1e9});
  std::vector<std::size_t> tets(kSlabs, 0);
  support::run_ranks(1, [&](Peers& peers) {
    DecompositionOptions options;
    options.num_subdomains = kSlabs;
    options.partitioner = parse_partitioner(partitioner, kSlabs);
    options.equal_tets = true;
    MeshSlice slice = support::slice_of(whole, 0, 1);
    options.coordinate = boundary_coordinate(peers, slice, options.partitioner.coordinate).values;
    for (const SubdomainStart& s : distribute(peers, std::move(slice), options).starts) {
      tets[s.subdomain.value] = s.tets.size();
      for (const auto& t : s.tets) {
        Point middle;
        for (const std::uint32_t v : t) middle += 0.25 * s.points[v];
        auto& [least, most] = reach[s.subdomain.value];
        least = std::min(least, exact(middle)), most = std::max(most, exact(middle));
      }
    }
  });
  for (std::uint32_t s = 0; s < kSlabs; ++s) {
    EXPECT_NEAR(static_cast<double>(tets[s]), static_cast<double>(mesh.tets.size()) / kSlabs, 1)
        << partitioner;
    if (s > 0) {
      EXPECT_LT(reach[s - 1][1], reach[s][0] + size) << partitioner << ", slab " << s;
    }
    if (s > 1) {
      EXPECT_LT(reach[s - 2][1], reach[s][0]) << partitioner << ", slab " << s;
    }
  }
}

TEST(BoundaryCoordinate, SlabsFollowIt) {
  expect_in_order("pqr:4x1x1:harmonic=1,2", angle_of, 0.15);
  expect_in_order("pqr:harmonic=3,4", radius_of, 0.15);
  expect_in_order("pqr:4x1x1:wall=3", radius_of, 0.15);
}

TEST(BoundaryCoordinate, SlabsNeedIt) {
  SelfPeers alone;
  const support::MetricMesh whole = support::random_metric_mesh(3);
  EXPECT_THROW(
      distribute(alone, support::slice_of(whole, 0, 1), {2, parse_partitioner("pqr:2x1x1:wall=1"), 45}),
      std::invalid_argument);
}

}  // namespace
}  // namespace weft::partition
