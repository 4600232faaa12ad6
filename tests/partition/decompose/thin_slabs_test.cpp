// Thin slabs are merged as far as it takes, against a count of the faces by a map.
#include "partition/decompose/thin_slabs.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "meshing/mesh/tet_tables.h"
#include "partition/decompose/tet_measures.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/support/meshes.h"

namespace weft::partition::thin_slabs_test {
namespace {

using ::testing::ElementsAre;

/// Tets in slabs of equal width, along each axis, of a cube of unit sides.
struct Scene {
  std::vector<std::array<std::uint32_t, 4>> vertices;
  std::vector<std::array<float, 4>> areas;
  std::vector<double> complexities;
  Bricks bricks;
};

/// The metric wants `size` everywhere.
Scene scene_of(std::uint32_t cells, const Slabs& slabs, double size, unsigned seed) {
  meshing::MeshData mesh = support::unit_cube(cells);
  support::jitter_interior(mesh, 0.1 / cells, seed);
  support::shuffle(mesh, seed);
  Scene scene{mesh.tets, {}, {}, {slabs, {}}};
  for (const auto& t : mesh.tets) {
    const TetCorners tet{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]};
    scene.areas.push_back(face_areas(tet, meshing::identity_tensor(), std::pow(size, -2)));
    scene.complexities.push_back(six_volume(tet[0], tet[1], tet[2], tet[3]) / 6 / std::pow(size, 3));
    const meshing::Point centre = 0.25 * (tet[0] + tet[1] + (tet[2] + tet[3]));
    std::uint32_t brick = 0;
    for (int axis = 0; axis < 3; ++axis)
      brick = brick * slabs[axis] + static_cast<std::uint32_t>(centre[axis] * slabs[axis]);
    scene.bricks.numbers.push_back(brick);
  }
  return scene;
}

WorthwhileSlabs found_on(int ranks, const Scene& scene) {
  WorthwhileSlabs result;
  support::run_ranks(ranks, [&](Peers& peers) {
    Scene part{{}, {}, {}, {scene.bricks.slabs, {}}};
    for (std::size_t i = 0; i < scene.vertices.size(); ++i) {
      if (static_cast<int>(i / 3 % 17) % ranks != peers.rank()) continue;
      part.vertices.push_back(scene.vertices[i]);
      part.areas.push_back(scene.areas[i]);
      part.complexities.push_back(scene.complexities[i]);
      part.bricks.numbers.push_back(scene.bricks.numbers[i]);
    }
    const WorthwhileSlabs found =
        worthwhile_slabs(peers, {part.vertices, part.areas}, part.complexities, part.bricks);
    if (peers.rank() == 0) result = found;
  });
  return result;
}

Slabs worthwhile_on(int ranks, const Scene& scene) { return found_on(ranks, scene).slabs; }

/// The slab of a brick along an axis.
std::uint32_t slab_of(std::uint32_t s, const Slabs& slabs, int axis) {
  return axis == 2 ? s % slabs[2] : axis == 1 ? s / slabs[2] % slabs[1] : s / slabs[2] / slabs[1];
}

/// The slab of `to` that slab i of `from` becomes part of.
std::uint32_t merged(std::uint32_t i, std::uint32_t from, std::uint32_t to) {
  return static_cast<std::uint32_t>(std::uint64_t{i} * to / from);
}

/// The share of the vertices that lie on faces between slabs merged to `to`, as often as there are cuts
/// between.
double shared(const Scene& scene, const Slabs& to) {
  std::map<std::array<std::uint32_t, 3>, std::vector<std::pair<std::uint32_t, float>>> faces;
  for (std::size_t t = 0; t < scene.vertices.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      std::array<std::uint32_t, 3> key;
      for (std::size_t i = 0; i < 3; ++i) key[i] = scene.vertices[t][meshing::kTetFaces[f][i]];
      std::sort(key.begin(), key.end());
      faces[key].push_back({scene.bricks.numbers[t], scene.areas[t][f]});
    }
  const Slabs& from = scene.bricks.slabs;
  double vertices = 0;
  for (const auto& [key, sides] : faces) {
    if (sides.size() != 2) continue;
    const double wanted = std::max(0.5, vertices_wanted(sides[0].second, sides[1].second));
    for (int axis = 0; axis < 3; ++axis) {
      const auto place = [&](std::uint32_t s) -> int {
        return static_cast<int>(merged(slab_of(s, from, axis), from[axis], to[axis]));
      };
      vertices += wanted * std::abs(place(sides[0].first) - place(sides[1].first));
    }
  }
  return vertices / (2 * std::accumulate(scene.complexities.begin(), scene.complexities.end(), 0.0));
}

TEST(ThinSlabs, AreAsManyAsShareLittle) {
  for (const double size : {0.006, 0.007, 0.009, 0.011}) {
    SCOPED_TRACE(size);
    const Scene scene = scene_of(12, {48, 1, 1}, size, 1);
    ASSERT_GT(shared(scene, scene.bricks.slabs), kMostShared);
    const Slabs left = worthwhile_on(2, scene);
    EXPECT_GT(left[0], fewest_slabs(48));
    EXPECT_LT(left[0], 48u);
    EXPECT_LE(shared(scene, left), kMostShared);
    EXPECT_GT(shared(scene, {left[0] + std::max(1u, left[0] / 6), 1, 1}), 0.97 * kMostShared);
  }
}

TEST(ThinSlabs, AreNoFewerThanCubesNeed) {
  EXPECT_THAT(worthwhile_on(2, scene_of(12, {48, 1, 1}, 0.05, 2)), ElementsAre(8, 1, 1));
  EXPECT_THAT(worthwhile_on(2, scene_of(12, {1, 1, 300}, 0.05, 2)), ElementsAre(1, 1, fewest_slabs(300)));
}

TEST(ThinSlabs, SayWhatTheyShareAlsoWhereItIsMoreThanWanted) {
  for (const double size : {0.009, 0.02, 0.05}) {
    SCOPED_TRACE(size);
    const Scene scene = scene_of(12, {48, 1, 1}, size, 2);
    const WorthwhileSlabs found = found_on(2, scene);
    EXPECT_NEAR(found.share_asked, std::min(shared(scene, scene.bricks.slabs), 1.0), 1e-3);
    EXPECT_NEAR(found.share_left, shared(scene, found.slabs), 1e-3);
    EXPECT_EQ(found.share_left > kMostShared, size > 0.01);
  }
}

TEST(ThinSlabs, StayWhereTheyAreThick) {
  EXPECT_THAT(worthwhile_on(3, scene_of(12, {16, 1, 1}, 0.001, 3)), ElementsAre(16, 1, 1));
}

TEST(ThinSlabs, StayWhereTheyAreFewOrNothingIsKnown) {
  for (const Slabs& slabs : {Slabs{8, 1, 1}, {6, 5, 4}, {10, 10, 10}, {1, 1, 1}})
    EXPECT_EQ(worthwhile_on(2, scene_of(10, slabs, 0.1, 4)), slabs);
  Scene scene = scene_of(10, {32, 1, 1}, 0.1, 4);
  scene.complexities.assign(scene.complexities.size(), 0);
  EXPECT_THAT(worthwhile_on(2, scene), ElementsAre(32, 1, 1));
}

TEST(ThinSlabs, BecomeFewerAlongTheAxesThatHaveMany) {
  EXPECT_THAT(worthwhile_on(2, scene_of(12, {2, 40, 2}, 0.05, 5)), ElementsAre(2, fewest_slabs(160), 2));
  EXPECT_THAT(worthwhile_on(2, scene_of(12, {30, 20, 1}, 0.05, 5)),
              ElementsAre(fewest_slabs(600), fewest_slabs(600), 1));
  // The greater of two cuts goes first.
  const Slabs left = worthwhile_on(2, scene_of(12, {60, 3, 30}, 0.009, 5));
  EXPECT_LT(left[0], 60u);
  EXPECT_EQ(left[1], 3u);
  EXPECT_LE(std::max(left[0], left[2]), std::min(left[0], left[2]) + 12);
}

TEST(ThinSlabs, AreTheSameOnAnyNumberOfRanks) {
  const Scene scene = scene_of(8, {32, 3, 1}, 0.01, 6);
  const Slabs expected = worthwhile_on(1, scene);
  EXPECT_NE(expected, scene.bricks.slabs);
  for (const int ranks : support::kNumbersOfRanks) EXPECT_EQ(worthwhile_on(ranks, scene), expected) << ranks;
}

TEST(ThinSlabs, AreHalfAsManyAgainAsOfCubesAtTheFewest) {
  EXPECT_EQ(fewest_slabs(1), 8u);
  EXPECT_EQ(fewest_slabs(151), 8u);
  EXPECT_EQ(fewest_slabs(152), 9u);
  EXPECT_EQ(fewest_slabs(1000), 15u);
  EXPECT_EQ(fewest_slabs(1 << 23), 305u);
}

}  // namespace
}  // namespace weft::partition::thin_slabs_test
