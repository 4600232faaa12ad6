// The metric of walls of a mesh in parts has the bits of the whole mesh's.
#include "partition/metric/wall_metric_in_parts.h"

#include <gtest/gtest.h>

#include <exception>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/base/sort_unique.h"
#include "meshing/metric/sources/wall_metric.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/metric_meshes.h"

namespace weft::partition::wall_metric_in_parts_test {
namespace {

using meshing::LogMetricField;
using meshing::MeshData;

LogMetricField in_parts(Peers& peers, const MeshSlice& slice, const WallOptions& options) {
  const PartDomain domain(peers, slice, 2);
  const LogMetricField field = wall_metric_in_parts(peers, slice, domain, options);
  LogMetricField refreshed = field;
  domain.refresh(refreshed);
  EXPECT_EQ(field, refreshed) << "vertices of other owners";
  return domain.to_slices(field);
}

void expect_that_of_the_whole(const MeshData& mesh, const WallOptions& options) {
  const LogMetricField expected = meshing::wall_metric(mesh, options);
  for (const int ranks : support::kNumbersOfRanks)
    for (const unsigned seed : {0u, 4u, 5u}) {
      SCOPED_TRACE(std::to_string(ranks) + " ranks, shares " + std::to_string(seed));
      support::run_ranks(ranks, [&](Peers& peers) {
        const MeshSlice slice = support::slice_of({mesh, {}}, peers.rank(), ranks, seed);
        const LogMetricField found = in_parts(peers, slice, options);
        const auto first = expected.begin() + static_cast<std::ptrdiff_t>(slice.first_point);
        EXPECT_EQ(found, LogMetricField(first, first + static_cast<std::ptrdiff_t>(found.size())));
      });
    }
}

/// Some of the references of the triangles.
std::vector<std::int32_t> walls_of(const MeshData& mesh, unsigned seed) {
  std::vector<std::int32_t> refs = mesh.triangle_refs;
  meshing::sort_unique(refs);
  refs.resize(1 + seed % refs.size());
  return refs;
}

TEST(WallMetricInParts, HasTheBitsOfTheWholeMesh) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    const MeshData mesh = support::random_metric_mesh(seed).mesh;
    expect_that_of_the_whole(mesh, {walls_of(mesh, seed), 0.01, 1.3, seed % 2 ? 0.2 : 0});
  }
}

TEST(WallMetricInParts, WhereManyTrianglesAreEquallyNear) {
  MeshData mesh = support::unit_cube(6);  // points over edges, and halfway between walls
  support::shuffle(mesh, 3);
  expect_that_of_the_whole(mesh, {{1, 2, 5, 6}, 0.01, 1.3, 0.1});
}

TEST(WallMetricInParts, OfACurvedWallInShares) {
  MeshData mesh = support::ball(3, 2);  // 1280 triangles: too many for all ranks to have them
  support::shuffle(mesh, 6);
  for (meshing::Point& p : mesh.points) p.z *= 0.4;
  expect_that_of_the_whole(mesh, {{mesh.triangle_refs[0]}, 0.01, 1.3, 0.1});
}

TEST(WallMetricInParts, OfOneTriangle) {
  MeshData mesh = support::ball(2, 3);
  mesh.triangle_refs[17] = 9;
  expect_that_of_the_whole(mesh, {{9}, 0.01, 1.3, 0});
}

TEST(WallMetricInParts, SaysWhatIsWrongOnAllRanks) {
  const support::MetricMesh whole{support::unit_cube(2), {}};
  const auto expect_error = [&](const WallOptions& options, const std::string& expected) {
    for (const int ranks : support::kNumbersOfRanks)
      for (const std::exception_ptr& e : support::run_ranks_caught(ranks, [&](Peers& peers) {
             in_parts(peers, support::slice_of(whole, peers.rank(), ranks), options);
           })) {
        ASSERT_TRUE(e);
        try {
          std::rethrow_exception(e);
        } catch (const meshing::InputError& error) {
          EXPECT_EQ(std::string(error.what()), expected);
        }
      }
  };
  expect_error({{1, 77}, 0.1, 1.2, 0}, "wall 77: no triangle has this reference");
  expect_error({{1}, 0, 1.2, 0}, "wall: the height of the first layer is not positive");
}

}  // namespace
}  // namespace weft::partition::wall_metric_in_parts_test
