// Cuts by runs: the same for any number of ranks and any shares.
#include "partition/decompose/runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>

#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::partition::runs_test {
namespace {

using meshing::MeshData;

constexpr std::uint32_t kParts = 5;

TetCorners corners_of(const MeshData& mesh, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return {mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]};
}

double work_at(const MeshData& mesh, std::size_t t) { return 1 + 3 * mesh.points[mesh.tets[t][0]].x; }

/// The part of every tet, with shares drawn by `seed` (0: even).
std::vector<SubdomainId> parts_on(int ranks, const MeshData& mesh, unsigned seed) {
  std::vector<SubdomainId> all(mesh.tets.size());
  support::run_ranks(ranks, [&](Peers& peers) {
    const auto begin = support::share_begin(mesh.tets.size(), peers.rank(), ranks, seed);
    const auto end = support::share_begin(mesh.tets.size(), peers.rank() + 1, ranks, seed);
    std::vector<double> work;
    for (std::size_t t = begin; t < end; ++t) work.push_back(work_at(mesh, t));
    const auto sample = [&](std::size_t i) {
      return RunSample{corners_of(mesh, begin + i), meshing::identity_tensor()};
    };
    const auto parts = bisect_runs(peers, Ranges(peers, end - begin), work, sample, kParts);
    ASSERT_EQ(parts.size(), end - begin);
    std::copy(parts.begin(), parts.end(), all.begin() + static_cast<std::ptrdiff_t>(begin));
  });
  return all;
}

bool follow_on(int ranks, const MeshData& mesh, unsigned seed) {
  std::set<bool> answers;
  std::mutex lock;
  support::run_ranks(ranks, [&](Peers& peers) {
    const auto begin = support::share_begin(mesh.tets.size(), peers.rank(), ranks, seed);
    const auto end = support::share_begin(mesh.tets.size(), peers.rank() + 1, ranks, seed);
    const bool mine = follow_each_other(peers, std::span(mesh.tets).subspan(begin, end - begin));
    const std::scoped_lock hold(lock);
    answers.insert(mine);
  });
  EXPECT_EQ(answers.size(), 1u);
  return *answers.begin();
}

TEST(Runs, AreCutAlikeOnAnyRanks) {
  const MeshData mesh = support::unit_cube(7);  // 2,058 tets: the last run is short
  const auto expected = parts_on(1, mesh, 0);
  for (const int ranks : support::kNumbersOfRanks)
    for (const unsigned seed : {0u, 1u, 2u, 3u}) EXPECT_EQ(parts_on(ranks, mesh, seed), expected) << ranks;
  // Slices that are shorter than runs.
  EXPECT_EQ(parts_on(9, support::unit_cube(2), 0), parts_on(1, support::unit_cube(2), 0));
}

TEST(Runs, HaveTheirShareOfTheWorkAndStayWhole) {
  const MeshData mesh = support::unit_cube(12);
  const auto parts = parts_on(2, mesh, 0);
  std::map<std::uint32_t, double> loads;
  double total = 0, largest = 0;
  for (std::size_t t = 0; t < parts.size(); ++t) {
    loads[parts[t].value] += work_at(mesh, t);
    total += work_at(mesh, t);
    largest = std::max(largest, work_at(mesh, t));
    EXPECT_TRUE(t % 32 == 0 || parts[t] == parts[t - 1]) << t;
  }
  ASSERT_EQ(loads.size(), kParts);
  for (const auto& [part, load] : loads) EXPECT_NEAR(load, total / kParts, 3 * 32 * largest) << part;
}

TEST(Runs, TetsInAnyOrderDoNotFollowEachOther) {
  MeshData mesh = support::unit_cube(7);
  for (const int ranks : support::kNumbersOfRanks) EXPECT_TRUE(follow_on(ranks, mesh, 3));
  support::shuffle(mesh, 1);
  for (const int ranks : support::kNumbersOfRanks) EXPECT_FALSE(follow_on(ranks, mesh, 3));
}

}  // namespace
}  // namespace weft::partition::runs_test
