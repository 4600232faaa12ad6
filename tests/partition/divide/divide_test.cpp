// Random bodies cut at random into few subdomains, which divide: no tet is lost, and all holders know each
// other.
#include "partition/divide/divide.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "partition/decompose/decomposition.h"
#include "tests/partition/shift/shift_checks.h"
#include "tests/support/kernel.h"

namespace weft::partition::divide_test {
namespace {

using namespace weft::support;
using ::testing::ElementsAre;

constexpr std::uint32_t kParts = 3;

/// Each subdomain of the scene with room for kParts.
Scene with_room(Scene scene) {
  for (SubdomainId& s : scene.part) s.value *= kParts;
  scene.subdomains *= kParts;
  return scene;
}

std::vector<std::uint32_t> parts_of(const Scene& scene) {
  std::vector<std::uint32_t> parts(scene.subdomains, 0);
  for (std::size_t i = 0; i < parts.size(); i += kParts) parts[i] = kParts;
  return parts;
}

/// Only seeds take part in shifts before they divide.
std::vector<Priority> priorities_of_all(std::size_t subdomains) {
  std::vector<Priority> priorities;
  for (std::uint32_t i = 0; i < subdomains; ++i) priorities.push_back({i % 7, SubdomainId(i)});
  return priorities;
}

void divide_and_check(const Scene& scene, bool after_a_shift) {
  const Cut cut = scene.cut();
  const ExpectedTotals totals = totals_of(scene.mesh);
  Rounds rounds(cut, scene.hausd(), {});
  if (after_a_shift) {  // holders and owners are others than at the start
    rounds.shift(priorities_of_all(scene.subdomains));
    ASSERT_EQ(rounds.update(), 0);
  }
  const auto before = tets_of(rounds.subdomains());
  rounds.divide(parts_of(scene));
  EXPECT_EQ(rounds.update(), 0) << "subdomains that did not get the notices that they expected";
  expect_sound(rounds, totals);
  const auto after = tets_of(rounds.subdomains());
  ASSERT_EQ(after.size(), before.size());
  for (const auto& [tet, place] : after) {
    const auto old = before.find(tet);
    ASSERT_NE(old, before.end());
    ASSERT_EQ(place.value / kParts, old->second.value / kParts) << "a part of another subdomain";
  }
  for (std::size_t i = 0; i < scene.subdomains; i += kParts) {
    std::uint64_t all = 0;
    for (std::size_t p = i; p < i + kParts; ++p) all += count_tets(rounds.subdomains()[p]);
    if (all < 20 * kParts) continue;
    for (std::size_t p = i; p < i + kParts; ++p) EXPECT_GT(count_tets(rounds.subdomains()[p]), 0u) << p;
  }
  // What was inside one subdomain has never been of an interface; now it can be freed as any other.
  rounds.shift(priorities_of_all(scene.subdomains));
  EXPECT_EQ(rounds.update(), 0);
  expect_sound(rounds, totals);
  EXPECT_EQ(tets_of(rounds.subdomains()).size(), before.size());
}

TEST(Division, LosesNothingAndTellsAllHolders) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    const Scene scene = with_room(random_scene(seed, 1));
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name);
    EXPECT_NO_THROW(divide_and_check(scene, seed % 2 == 1));
    if (HasFailure()) return;
  }
}

TEST(Division, OfAWholeMeshIsItsDecomposition) {
  Scene scene{"cube", unit_cube(6), {}, {}, 8, false};
  scene.log_metrics = wanted_sizes(scene.mesh, 0.05, 3);
  scene.part.assign(scene.mesh.tets.size(), SubdomainId(0));
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  std::vector<std::uint32_t> parts(8, 0);
  parts[0] = 8;
  rounds.divide(parts);
  EXPECT_EQ(rounds.update(), 0);
  expect_sound(rounds, totals_of(scene.mesh));
  std::vector<double> work;
  for (const Subdomain& s : rounds.subdomains()) work.push_back(predicted_tets(s));
  const double mean = std::accumulate(work.begin(), work.end(), 0.0) / 8;
  EXPECT_LT(*std::ranges::max_element(work), 1.15 * mean) << "they have the same work";
}

TEST(Division, LeavesTheBackgroundThatIsCovered) {
  constexpr std::uint32_t kOfCube = 8;
  Scene scene{"cube", unit_cube(20), {}, {}, kOfCube, false};
  scene.log_metrics = wanted_sizes(scene.mesh, 0.05, 3);
  scene.part.assign(scene.mesh.tets.size(), SubdomainId(0));
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  const std::size_t before = rounds.subdomains()[0].background.num_pieces();
  std::vector<std::uint32_t> parts(kOfCube, 0);
  parts[0] = kOfCube;
  rounds.divide(parts);
  EXPECT_EQ(rounds.update(), 0);
  for (const Subdomain& s : rounds.subdomains()) {
    EXPECT_LT(s.background.num_pieces(), before * 3 / 4) << s.id.value;
    for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i) {
      const meshing::VertexId v(i);
      if (!s.mesh->alive(v)) continue;
      const auto sample = s.background.background().at(s.mesh->point(v), s.mesh->background_hint(v));
      ASSERT_NEAR(trace(sample.log_metric), trace(s.mesh->log_metric(v)), 1e-9) << s.id.value;
    }
  }
}

/// A fine cube has become a few hundred tets, each of which covers some hundreds of the input's.
TEST(Division, OfAMeshThatIsCoarserThanItsBackgroundLeavesAllThatIsCovered) {
  constexpr std::uint32_t kOfCube = 6;
  Scene scene{"cube", unit_cube(26), {}, {}, kOfCube, false};
  scene.log_metrics = uniform_metric(scene.mesh, 0.4);
  scene.part.assign(scene.mesh.tets.size(), SubdomainId(0));
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  rounds.options().coarsen = true;
  rounds.adapt(meshing::Extent::everything);
  ASSERT_LT(count_tets(rounds.subdomains()[0]), 400u);
  BackgroundStore whole;
  whole.add(rounds.subdomains()[0].background.all_pieces());
  std::vector<std::uint32_t> parts(kOfCube, 0);
  parts[0] = kOfCube;
  rounds.divide(parts);
  EXPECT_EQ(rounds.update(), 0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> weight(0.01, 1);
  std::size_t points = 0, without = 0, pieces = 0;
  for (const Subdomain& s : rounds.subdomains()) {
    pieces += s.background.num_pieces();
    for (std::uint32_t i = 0; i < s.mesh->tet_slots(); ++i) {
      if (!s.mesh->alive(meshing::TetId(i))) continue;
      for (int k = 0; k < 200; ++k, ++points) {
        double sum = 0;
        meshing::Point p;
        for (const meshing::VertexId v : s.mesh->vertices(meshing::TetId(i))) {
          const double w = weight(random);
          p += w * s.mesh->point(v);
          sum += w;
        }
        const auto there = whole.background().walk_towards((1 / sum) * p, meshing::Background::kNoHint);
        ASSERT_TRUE(there.reached);
        without += !s.background.has(whole.name_of(there.tet).piece);
      }
    }
  }
  EXPECT_EQ(without, 0u) << "of " << points << " points";
  EXPECT_LT(pieces, 4 * whole.num_pieces()) << "parts have about what they cover";
}

TEST(Division, OfOneIntoOneChangesNothing) {
  const Scene scene = random_scene(9, 1);
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  const auto before = tets_of(rounds.subdomains());
  rounds.divide(std::vector<std::uint32_t>(scene.subdomains, 1));
  EXPECT_EQ(rounds.update(), 0);
  EXPECT_EQ(tets_of(rounds.subdomains()), before);
  expect_sound(rounds, totals_of(scene.mesh));
}

TEST(Apportion, GivesEachItsShareAndAtLeastOne) {
  EXPECT_THAT(apportion(std::vector<std::uint64_t>{100}, 7), ElementsAre(7));
  EXPECT_THAT(apportion(std::vector<std::uint64_t>{100, 300}, 10), ElementsAre(3, 7));
  EXPECT_THAT(apportion(std::vector<std::uint64_t>{0, 1000, 0}, 10), ElementsAre(1, 8, 1));
  EXPECT_THAT(apportion(std::vector<std::uint64_t>{0, 0}, 5), ElementsAre(3, 2)) << "nothing to do";
  EXPECT_THAT(apportion(std::vector<std::uint64_t>{5, 5, 5}, 3), ElementsAre(1, 1, 1));
  EXPECT_THAT(apportion(std::vector<std::uint64_t>{1, 1, 1}, 8), ElementsAre(3, 3, 2)) << "ties by number";
}

}  // namespace
}  // namespace weft::partition::divide_test
