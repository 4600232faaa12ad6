// The full check in shares against that of the whole mesh: sound meshes, ones that touch themselves, and
// damage.
#include "partition/verify/verify_slices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <random>

#include "meshing/mesh/check_mesh.h"
#include "partition/verify/connected_sets.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/metric_meshes.h"

namespace weft::partition {
namespace {

using meshing::CheckReport;
using meshing::MeshData;

void expect_near(const std::map<std::int32_t, double>& a, const std::map<std::int32_t, double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j) {
    EXPECT_EQ(i->first, j->first);
    EXPECT_NEAR(i->second, j->second, 1e-15 * std::abs(j->second));
  }
}

void expect_the_same(const MeshData& mesh, int max_problems = 20) {
  const CheckReport expected = meshing::check_mesh(mesh, max_problems);
  for (const int ranks : support::kNumbersOfRanks)
    for (const unsigned seed : {0u, 3u}) {
      SCOPED_TRACE(std::to_string(ranks) + " ranks, shares " + std::to_string(seed));
      std::vector<CheckReport> reports(static_cast<std::size_t>(ranks));
      support::run_ranks(ranks, [&](Peers& peers) {
        const support::MetricMesh whole{mesh, {}};
        reports[static_cast<std::size_t>(peers.rank())] =
            verify_slices(peers, support::slice_of(whole, peers.rank(), ranks, seed), max_problems);
      });
      for (const CheckReport& report : reports) {
        EXPECT_EQ(report.num_problems, expected.num_problems);
        EXPECT_EQ(report.problems, expected.problems);
        EXPECT_EQ(report.num_components, expected.num_components);
        EXPECT_EQ(report.unreferenced_points, expected.unreferenced_points);
        EXPECT_EQ(report.touching_edges, expected.touching_edges);
        EXPECT_EQ(report.touching_vertices, expected.touching_vertices);
        expect_near(report.volume_by_ref, expected.volume_by_ref);
        expect_near(report.area_by_ref, expected.area_by_ref);
      }
      if (::testing::Test::HasFailure()) return;
    }
}

TEST(VerifySlices, SoundMeshes) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    MeshData mesh = support::random_metric_mesh(seed).mesh;  // some lack triangles, or have some twice
    expect_the_same(mesh);
  }
  EXPECT_TRUE(meshing::check_mesh(support::layered_box(4, 2, 3)).ok());
  expect_the_same(support::layered_box(4, 2, 3));
  expect_the_same(MeshData{});
}

TEST(VerifySlices, BodiesThatTouchThemselvesOrAreSeveral) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    MeshData mesh = support::touching_cells(4, seed);
    support::shuffle(mesh, seed);
    const CheckReport report = meshing::check_mesh(mesh);
    EXPECT_GT(report.touching_edges, 0u);
    EXPECT_GT(report.touching_vertices, 0u);
    expect_the_same(mesh);
  }
  MeshData apart = support::unit_cube(3);  // what is left of it is in two halves
  std::erase_if(apart.tets, [&](const auto& tet) {
    double x = 0;
    for (const std::uint32_t v : tet) x += 0.25 * apart.points[v].x;
    return x > 1.0 / 3 && x < 2.0 / 3;
  });
  apart.tet_refs.resize(apart.tets.size());
  EXPECT_EQ(meshing::check_mesh(apart).num_components, 2u);
  expect_the_same(apart);
}

TEST(VerifySlices, Damage) {
  const std::vector<std::function<void(MeshData&, std::mt19937&)>> damages = {
      [](MeshData& m, std::mt19937& r) {
        std::swap(m.tets[r() % m.tets.size()][0], m.tets[r() % m.tets.size()][1]);
      },
      [](MeshData& m, std::mt19937& r) {
        std::ranges::reverse(m.tets[r() % m.tets.size()]), m.tets.front()[0] = m.tets.back()[0];
      },
      [](MeshData& m, std::mt19937& r) { std::swap(m.tets[r() % m.tets.size()][0], m.tets[3][1]); },
      [](MeshData& m, std::mt19937& r) {
        auto& tet = m.tets[r() % m.tets.size()];
        std::swap(tet[0], tet[1]);  // inverted
      },
      [](MeshData& m, std::mt19937& r) {
        m.tets.push_back(m.tets[r() % m.tets.size()]), m.tet_refs.push_back(4);
      },
      [](MeshData& m, std::mt19937& r) { m.tets.erase(m.tets.begin() + r() % 50), m.tet_refs.pop_back(); },
      [](MeshData& m, std::mt19937& r) { m.tet_refs[r() % m.tets.size()] = 77; },
      [](MeshData& m, std::mt19937& r) {
        m.triangles[r() % m.triangles.size()] = {0, 5, 9};
      },
      [](MeshData& m, std::mt19937& r) { m.triangles[r() % m.triangles.size()] = m.triangles[0]; },
      [](MeshData& m, std::mt19937& r) {
        m.edges[r() % m.edges.size()] = {0, static_cast<std::uint32_t>(m.points.size() - 1)};
      },
      [](MeshData& m, std::mt19937& r) {
        m.tets[r() % m.tets.size()][2] = static_cast<std::uint32_t>(m.points.size() + 5);
      },
      [](MeshData& m, std::mt19937& r) {
        m.points[r() % m.points.size()].y = std::numeric_limits<double>::quiet_NaN();
      },
      [](MeshData& m, std::mt19937& r) {
        m.corners.push_back(static_cast<std::uint32_t>(m.points.size() + r() % 9));
      },
      [](MeshData& m, std::mt19937&) { std::ranges::fill(m.tets, m.tets[0]); },
  };
  for (std::size_t i = 0; i < damages.size(); ++i) {
    SCOPED_TRACE("damage " + std::to_string(i));
    std::mt19937 random(static_cast<unsigned>(i));
    MeshData mesh = support::layered_box(3, 2, 2);
    support::shuffle(mesh, 5);
    damages[i](mesh, random);
    EXPECT_FALSE(meshing::check_mesh(mesh).ok());
    meshing::Problems arrays(1);
    meshing::check_arrays(mesh, arrays);
    const std::vector<std::string> first = arrays.take();
    support::run_ranks(3, [&](Peers& peers) {
      EXPECT_EQ(array_problem(peers, support::slice_of({mesh, {}}, peers.rank(), 3)),
                first.empty() ? "" : first[0]);
    });
    expect_the_same(mesh);
    expect_the_same(mesh, 3);
    if (HasFailure()) return;
  }
}

TEST(ConnectedSets, AreThoseOfOneRank) {
  std::mt19937 random(4);
  for (int repeat = 0; repeat < 30; ++repeat) {
    const std::uint64_t n = 1 + random() % 400, num_edges = random() % (2 * n);
    std::vector<std::array<std::uint64_t, 2>> edges;
    for (std::uint64_t i = 0; i < num_edges; ++i) edges.push_back({random() % n, random() % n});
    if (repeat % 5 == 0) {  // a path in random order
      std::vector<std::uint64_t> order(n);
      std::iota(order.begin(), order.end(), 0);
      std::ranges::shuffle(order, random);
      edges.clear();
      for (std::uint64_t i = 1; i < n; ++i) edges.push_back({order[i - 1], order[i]});
    }
    std::vector<std::uint64_t> label(n);
    std::iota(label.begin(), label.end(), 0);
    std::uint64_t expected = n;
    for (const auto& [a, b] : edges) {
      const std::uint64_t from = label[a], to = label[b];
      expected -= from != to;
      std::ranges::replace(label, from, to);
    }
    for (const int ranks : support::kNumbersOfRanks)
      support::run_ranks(ranks, [&](Peers& peers) {
        const auto begin = [&](int rank) {
          return n * static_cast<std::uint64_t>(rank) / static_cast<std::uint64_t>(ranks);
        };
        std::vector<std::array<std::uint64_t, 2>> mine;
        for (std::size_t i = 0; i < edges.size(); ++i)
          if (static_cast<int>(i % static_cast<std::size_t>(ranks)) == peers.rank()) mine.push_back(edges[i]);
        EXPECT_EQ(count_connected_sets(peers, begin(peers.rank() + 1) - begin(peers.rank()), mine), expected);
      });
  }
}

}  // namespace
}  // namespace weft::partition
