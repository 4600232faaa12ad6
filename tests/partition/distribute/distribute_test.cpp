// Distribution against the whole mesh: nothing lost, nothing twice, the same for any number of ranks.
#include "partition/distribute/distribute.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>

#include "meshing/adapt/adapt.h"
#include "meshing/io/mesh_file.h"
#include "meshing/kernel/import_mesh.h"
#include "meshing/mesh/tet_tables.h"
#include "meshing/metric/measures.h"
#include "partition/decompose/tet_measures.h"
#include "partition/refine/refine_interface.h"
#include "tests/partition/communication/counting_peers.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/metric_meshes.h"
#include "tests/support/case_files.h"
#include "tests/support/kernel.h"
#include "tests/support/repetitions.h"

namespace weft::partition::distribute_test {
namespace {

using meshing::MeshData;
using support::MetricMesh;

DecompositionOptions options_of(std::uint32_t n, const std::string& partitioner = "bisection") {
  return {n, parse_partitioner(partitioner, n), 45};
}

/// All ranks' starts by subdomain, and the rest as rank 0 has it.
Distributed distribute_on(int ranks, const MetricMesh& whole, const DecompositionOptions& options,
                          unsigned seed = 0) {
  std::vector<Distributed> parts(static_cast<std::size_t>(ranks));
  support::run_ranks(ranks, [&](Peers& peers) {
    parts[static_cast<std::size_t>(peers.rank())] =
        distribute(peers, support::slice_of(whole, peers.rank(), ranks, seed), options);
  });
  for (int r = 0; r < ranks; ++r) {
    const Distributed& part = parts[static_cast<std::size_t>(r)];
    EXPECT_EQ(part.warnings, parts[0].warnings);
    EXPECT_EQ(part.complexity, parts[0].complexity);
    for (const SubdomainStart& start : part.starts)
      EXPECT_EQ(home_rank(start.subdomain, options.num_subdomains, ranks), r);
    if (r > 0) parts[0].starts.insert(parts[0].starts.end(), part.starts.begin(), part.starts.end());
  }
  return std::move(parts[0]);
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same_pieces(const SubdomainStart& a, const SubdomainStart& b) {
  return std::ranges::equal(a.surface, b.surface, [](const auto& x, const auto& y) {
    return std::ranges::equal(x->bytes(), y->bytes());
  });
}

bool same(const SubdomainStart& a, const SubdomainStart& b) {
  return a.subdomain == b.subdomain && same_bytes(a.points, b.points) && a.point_refs == b.point_refs &&
         same_bytes(a.log_metrics, b.log_metrics) && a.ids == b.ids && a.kinds == b.kinds &&
         a.flags == b.flags && a.surface_hints == b.surface_hints && a.tets == b.tets &&
         a.tet_refs == b.tet_refs && same_bytes(a.boundary_faces, b.boundary_faces) &&
         same_bytes(a.feature_edges, b.feature_edges) && a.shared == b.shared && same_pieces(a, b);
}

std::uint32_t number(const SubdomainStart& start, std::uint32_t vertex) {
  return static_cast<std::uint32_t>(start.ids[vertex].local());
}

class Distribute : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(Distribute, DoesNotDependOnTheNumberOfRanks) {
  for (unsigned seed = 1; seed <= support::repetitions(2, 4); ++seed) {
    const MetricMesh whole = support::random_metric_mesh(seed);
    const auto options = options_of(GetParam(), seed % 2 ? "bisection" : "graph");
    const Distributed expected = distribute_on(1, whole, options);
    ASSERT_EQ(expected.starts.size(), GetParam());
    for (const int ranks : support::kNumbersOfRanks) {
      const Distributed found = distribute_on(ranks, whole, options, seed + static_cast<unsigned>(ranks));
      ASSERT_EQ(found.starts.size(), GetParam());
      for (SubdomainId s(0); s.value < GetParam(); ++s.value)
        ASSERT_TRUE(same(found.starts[s.value], expected.starts[s.value]))
            << s << " on " << ranks << " ranks";
      EXPECT_EQ(found.warnings, expected.warnings);
      EXPECT_EQ(found.complexity, expected.complexity);
      EXPECT_EQ(found.box.lo, expected.box.lo);
      EXPECT_EQ(found.box.hi, expected.box.hi);
    }
  }
}

/// A curved surface of forty pieces: each rank keeps those near its subdomains, the same for any number of
/// ranks, and all of them are kept by somebody.
TEST(Distribute, KeepsTheSurfaceWhereItIsNeeded) {
  MetricMesh whole{support::ball(4, 1), {}};
  whole.log_metrics.assign(whole.mesh.points.size(), {});
  const meshing::Surface surface(whole.mesh, {45});
  std::size_t bytes = 0;
  for (const auto& piece : surface.pieces().all()) bytes += piece->bytes().size();
  const Distributed expected = distribute_on(1, whole, options_of(16));
  for (const int ranks : {1, 2, 4, 8}) {
    const Distributed d = distribute_on(ranks, whole, options_of(16));
    EXPECT_TRUE(d.geometry->surface.pieces().all().empty());
    std::vector<std::map<std::uint32_t, std::size_t>> kept(static_cast<std::size_t>(ranks));
    std::set<std::uint32_t> anywhere;
    for (std::uint32_t s = 0; s < 16; ++s) {
      EXPECT_TRUE(same(d.starts[s], expected.starts[s]));
      for (const auto& piece : d.starts[s].surface) {
        kept[static_cast<std::size_t>(home_rank(SubdomainId(s), 16, ranks))][piece->id] =
            piece->bytes().size();
        anywhere.insert(piece->id);
      }
    }
    EXPECT_EQ(anywhere.size(), surface.pieces().all().size());
    for (const auto& of_rank : kept) {
      std::size_t here = 0;
      for (const auto& [id, size] : of_rank) here += size;
      EXPECT_LE(here, ranks < 8 ? bytes : bytes * 3 / 5);
    }
  }
}

/// Work piles up in a corner: parts of equal work there have few of the input's tets.
TEST(Distribute, DividesWorkOrTets) {
  MetricMesh whole = support::random_metric_mesh(1);
  for (std::size_t v = 0; v < whole.mesh.points.size(); ++v)
    whole.log_metrics[v] = meshing::LogMetric(
        meshing::identity_tensor(norm(whole.mesh.points[v] - whole.mesh.points[0]) < 0.3 ? 8 : 0));
  auto options = options_of(8);
  const auto most_and_least = [&] {
    std::vector<std::size_t> tets;
    for (const SubdomainStart& start : distribute_on(2, whole, options).starts)
      tets.push_back(start.tets.size());
    const auto [least, most] = std::minmax_element(tets.begin(), tets.end());
    return std::pair(*most, *least);
  };
  const auto [most, least] = most_and_least();
  EXPECT_GT(most, 2 * least);
  options.equal_tets = true;
  const auto [most_tets, least_tets] = most_and_least();
  EXPECT_LE(most_tets, least_tets + 3);  // half a tet for each of three cuts, on either side
}

/// Tets count by what becomes of them.
TEST(Distribute, MeanQualityIsWeighedByComplexity) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const MetricMesh whole = support::random_metric_mesh(seed);
    double complexity = 0, weighed = 0, plain = 0;
    for (const meshing::Tet& t : whole.mesh.tets) {
      std::array<meshing::Point, 4> x;
      std::array<meshing::LogMetric, 4> l;
      double volume = 0;
      for (std::size_t i = 0; i < 4; ++i) x[i] = whole.mesh.points[t[i]], l[i] = whole.log_metrics[t[i]];
      for (std::size_t i = 0; i < 4; ++i)
        volume += std::exp(trace(l[i]) / 2) / 4 * meshing::six_volume(x[0], x[1], x[2], x[3]) / 6;
      const double quality = std::max(0.0, meshing::mean_ratio(x, l));
      complexity += volume, weighed += volume * quality, plain += quality;
    }
    const double expected = weighed / complexity;
    EXPECT_GT(std::abs(expected - plain / static_cast<double>(whole.mesh.tets.size())), 1e-3)
        << "shows nothing";
    for (const int ranks : {1, 3})
      EXPECT_NEAR(distribute_on(ranks, whole, options_of(2)).mean_quality, expected, 1e-9);
  }
}

TEST(Distribute, WhatIsNearlyRightIsCutByRuns) {
  const MeshData cube = support::unit_cube(5);
  const meshing::LogMetricField metric = support::uniform_metric(cube, 0.12);
  meshing::AdaptResult adapted = meshing::adapt(cube, {&cube, &metric}, {});
  MetricMesh whole{std::move(adapted.mesh), std::move(adapted.log_metrics)};
  auto options = options_of(6, "graph");
  const auto shared = [](const Distributed& d) {
    std::size_t count = 0;
    for (const SubdomainStart& start : d.starts) count += start.shared.size();
    return static_cast<double>(count);
  };
  const Distributed by_graph = distribute_on(1, whole, options);
  EXPECT_FALSE(by_graph.cut_by_runs);
  options.partitioner.runs_suffice = true;
  const Distributed expected = distribute_on(1, whole, options);
  EXPECT_TRUE(expected.cut_by_runs);
  EXPECT_LT(shared(expected), 1.6 * shared(by_graph));
  for (const int ranks : support::kNumbersOfRanks) {
    const Distributed found = distribute_on(ranks, whole, options, static_cast<unsigned>(ranks));
    EXPECT_TRUE(found.cut_by_runs);
    for (SubdomainId s(0); s.value < 6; ++s.value)
      EXPECT_TRUE(same(found.starts[s.value], expected.starts[s.value])) << s << " on " << ranks << " ranks";
  }
  options.target_complexity = 2 * expected.complexity;
  EXPECT_FALSE(distribute_on(2, whole, options).cut_by_runs);
  options.target_complexity = 0;
  support::shuffle(whole.mesh);
  whole.log_metrics = support::uniform_metric(whole.mesh, 0.12);
  EXPECT_FALSE(distribute_on(2, whole, options).cut_by_runs);
}

/// Compares the starts of one distribution with the kernel's own import of the whole mesh.
class Comparison {
 public:
  explicit Comparison(const MetricMesh& whole)
      : whole_(whole),
        imported_(meshing::import_mesh(whole.mesh, 45, whole.mesh.points.size(), whole.mesh.tets.size())) {
    for (std::uint32_t t = 0; t < whole.mesh.tets.size(); ++t) tet_of_[whole.mesh.tets[t]] = t;
  }

  void check(const Distributed& d) const {
    check_geometry(d);
    check_tets(d);
    check_holders(d);
    for (const SubdomainStart& start : d.starts) {
      check_vertices(start);
      check_boundary(start);
      check_features(start);
    }
    EXPECT_EQ(d.warnings, imported_.warnings);
    check_measures(d);
  }

 private:
  using V = meshing::VertexId;

  void check_geometry(const Distributed& d) const;
  void check_tets(const Distributed& d) const;
  void check_holders(const Distributed& d) const;
  void check_vertices(const SubdomainStart& start) const;
  void check_boundary(const SubdomainStart& start) const;
  void check_features(const SubdomainStart& start) const;
  void check_measures(const Distributed& d) const;

  const MetricMesh& whole_;
  meshing::ImportedMesh imported_;
  std::map<std::array<std::uint32_t, 4>, std::uint32_t> tet_of_;
};

void Comparison::check_geometry(const Distributed& d) const {
  const meshing::Surface &found = d.geometry->surface, &expected = *imported_.surface;
  ASSERT_EQ(found.patches().size(), expected.patches().size());
  for (std::size_t p = 0; p < found.patches().size(); ++p) {
    EXPECT_EQ(found.patches()[p].ref, expected.patches()[p].ref);
    EXPECT_EQ(found.patches()[p].planar, expected.patches()[p].planar);
    EXPECT_EQ(found.patches()[p].normal, expected.patches()[p].normal);
  }
  EXPECT_EQ(d.geometry->patch_required, imported_.patch_required);
  ASSERT_EQ(found.curves().size(), expected.curves().size());
  for (std::size_t c = 0; c < found.curves().size(); ++c) {
    EXPECT_EQ(found.curves()[c].ref, expected.curves()[c].ref);
    EXPECT_EQ(found.curves()[c].straight, expected.curves()[c].straight);
    EXPECT_EQ(found.curves()[c].required, expected.curves()[c].required);
  }
}

/// Vertices in their order, and the reference.
using NamedTet = std::pair<std::array<std::uint32_t, 4>, std::int32_t>;

void Comparison::check_tets(const Distributed& d) const {
  std::vector<NamedTet> expected, found;
  for (std::size_t t = 0; t < whole_.mesh.tets.size(); ++t)
    expected.emplace_back(whole_.mesh.tets[t], whole_.mesh.tet_refs[t]);
  for (const SubdomainStart& start : d.starts)
    for (std::size_t t = 0; t < start.tets.size(); ++t) {
      NamedTet tet{start.tets[t], start.tet_refs[t]};
      for (std::uint32_t& v : tet.first) v = number(start, v);
      found.push_back(tet);
    }
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, expected);
}

void Comparison::check_holders(const Distributed& d) const {
  std::map<std::uint32_t, std::set<SubdomainId>> holders;
  for (const SubdomainStart& start : d.starts)
    for (const auto& tet : start.tets)
      for (const std::uint32_t v : tet) holders[number(start, v)].insert(start.subdomain);
  for (const SubdomainStart& start : d.starts) {
    std::vector<SubdomainStart::Shared> expected;
    for (std::uint32_t v = 0; v < start.ids.size(); ++v) {
      const auto& all = holders[number(start, v)];
      EXPECT_TRUE(all.count(start.subdomain));  // no vertex without a tet
      EXPECT_EQ(start.ids[v].owner(), *all.begin());
      for (const SubdomainId other : all)
        if (other != start.subdomain) expected.push_back({v, other});
    }
    EXPECT_EQ(start.shared, expected);
  }
}

void Comparison::check_vertices(const SubdomainStart& start) const {
  const auto n = start.points.size();
  ASSERT_TRUE(start.point_refs.size() == n && start.log_metrics.size() == n && start.ids.size() == n &&
              start.kinds.size() == n && start.flags.size() == n && start.surface_hints.size() == n);
  for (std::uint32_t v = 0; v < n; ++v) {
    const std::uint32_t whole = number(start, v);
    EXPECT_EQ(start.points[v], whole_.mesh.points[whole]);
    EXPECT_EQ(start.point_refs[v], whole_.mesh.point_refs[whole]);
    EXPECT_EQ(start.log_metrics[v], whole_.log_metrics[whole]);
    EXPECT_EQ(start.kinds[v], imported_.mesh->kind(V(whole)));
    EXPECT_EQ(start.flags[v], imported_.mesh->flags(V(whole)));
    EXPECT_EQ(start.surface_hints[v], imported_.mesh->surface_hint(V(whole)));
  }
}

void Comparison::check_boundary(const SubdomainStart& start) const {
  std::map<std::pair<std::uint32_t, std::uint32_t>, meshing::PatchId> patches;
  for (const auto& face : start.boundary_faces) {
    EXPECT_TRUE(patches.try_emplace({face.tet, face.face}, face.patch).second);
  }
  for (std::uint32_t t = 0; t < start.tets.size(); ++t) {
    auto tet = start.tets[t];
    for (std::uint32_t& v : tet) v = number(start, v);
    for (std::uint32_t f = 0; f < 4; ++f) {
      const meshing::PatchId expected =
          imported_.mesh->patch(meshing::TetId(tet_of_.at(tet)), static_cast<int>(f));
      const auto found = patches.find({t, f});
      EXPECT_EQ(found == patches.end() ? meshing::PatchId{} : found->second, expected);
    }
  }
}

void Comparison::check_features(const SubdomainStart& start) const {
  std::map<std::array<std::uint32_t, 2>, meshing::CurveId> expected, found;
  for (const auto& tet : start.tets)
    for (const auto& edge : meshing::kTetEdges) {
      const auto [a, b] = std::minmax(tet[edge[0]], tet[edge[1]]);
      if (const auto curve = imported_.mesh->curve(V(number(start, a)), V(number(start, b))); curve.valid())
        expected[{a, b}] = curve;
    }
  for (const auto& edge : start.feature_edges) EXPECT_TRUE(found.try_emplace(edge.ends, edge.curve).second);
  EXPECT_EQ(found, expected);
}

void Comparison::check_measures(const Distributed& d) const {
  double volume = 0;
  meshing::Box box;
  for (const SubdomainStart& start : d.starts) {
    for (const auto& p : start.points) box.include(p);
    for (const auto& [a, b, c, e] : start.tets)
      volume += six_volume(start.points[a], start.points[b], start.points[c], start.points[e]) / 6;
  }
  const meshing::Measures expected = meshing::measure(whole_.mesh, whole_.log_metrics);
  EXPECT_NEAR(volume, expected.volume, 1e-12 * expected.volume);
  EXPECT_NEAR(d.complexity, expected.complexity, 1e-11 * expected.complexity);
  EXPECT_EQ(d.box.lo, box.lo);
  EXPECT_EQ(d.box.hi, box.hi);
}

TEST_P(Distribute, KeepsTheWholeMeshAndItsClassification) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const MetricMesh whole = support::random_metric_mesh(seed);
    const char* partitioners[] = {"bisection", "graph", "pqr", "pqr:principal"};
    SCOPED_TRACE(seed);
    Comparison(whole).check(distribute_on(3, whole, options_of(GetParam(), partitioners[seed % 4]), seed));
  }
}

INSTANTIATE_TEST_SUITE_P(Subdomains, Distribute, ::testing::Values(1, 2, 3, 16, 128, 1000));

TEST(DistributeSmall, MeshesMayHaveFewerTetsThanRanks) {
  MetricMesh whole{support::two_tets(), {}};
  whole.log_metrics.assign(5, {});
  for (const int ranks : support::kNumbersOfRanks)
    for (const std::uint32_t n : {1u, 2u, 7u})
      Comparison(whole).check(distribute_on(ranks, whole, options_of(n)));
}

TEST(DistributeCases, KeepTheirGeometry) {
  const std::filesystem::path folder = support::case_files();
  if (!std::filesystem::exists(folder))
    GTEST_SKIP() << "NOT TESTED: the case files are not at " << folder << " (set WEFT_CASES to their folder)";
  for (const char* name : {"delta-wing/coarse.meshb", "ugawg/cube-cylinder.meshb", "ugawg/cone-cone.meshb"}) {
    SCOPED_TRACE(name);
    MetricMesh whole{meshing::read_mesh(folder / name), {}};
    whole.log_metrics.assign(whole.mesh.points.size(), {});
    Comparison(whole).check(distribute_on(4, whole, options_of(6)));
  }
}

TEST(DistributeWarnings, AreThoseOfTheImport) {
  const MetricMesh whole = support::random_metric_mesh(6);
  using ::testing::ElementsAre;
  using ::testing::HasSubstr;
  EXPECT_THAT(distribute_on(4, whole, options_of(3)).warnings,
              ElementsAre(HasSubstr("repeated triangles"), HasSubstr("were missing and have been created"),
                          HasSubstr("edges that lie on no boundary triangle"),
                          HasSubstr("3 points that belong to no tet were dropped")));
}

TEST(DistributeWarnings, SayThatThinSlabsAreFewer) {
  MetricMesh whole{support::unit_cube(6), {}};
  whole.log_metrics.assign(whole.mesh.points.size(), {});
  using ::testing::Each;
  using ::testing::ElementsAre;
  using ::testing::Field;
  using ::testing::HasSubstr;
  using ::testing::IsEmpty;
  using ::testing::Not;
  const Distributed merged = distribute_on(3, whole, options_of(20, "pqr:1x20x1:fewer"));
  EXPECT_THAT(merged.warnings, ElementsAre(HasSubstr("1x8x1 have about")));
  EXPECT_EQ(merged.starts.size(), 20u);
  EXPECT_EQ(std::count_if(merged.starts.begin(), merged.starts.end(),
                          [](const SubdomainStart& s) { return s.tets.empty(); }),
            12);
  const Distributed all = distribute_on(3, whole, options_of(20, "pqr:1x20x1"));
  EXPECT_THAT(all.warnings, ElementsAre(HasSubstr("`:fewer` after the slabs")));
  EXPECT_THAT(all.starts, Each(Field(&SubdomainStart::tets, Not(IsEmpty()))));
}

TEST(DistributeBalance, DividesTheExpectedTets) {
  MetricMesh whole{support::unit_cube(8), {}};
  whole.log_metrics = support::random_metrics(whole.mesh, 2);
  for (const std::uint32_t n : {4u, 13u}) {
    const Distributed d = distribute_on(4, whole, options_of(n, "pqr:" + std::to_string(n) + "x1x1"));
    std::vector<double> work(n, 0);
    double total = 0, heaviest = 0;
    for (const SubdomainStart& start : d.starts)
      for (const auto& tet : start.tets) {
        std::array<double, 4> log_densities;
        for (std::size_t i = 0; i < 4; ++i) log_densities[i] = trace(start.log_metrics[tet[i]]) / 2;
        const auto& p = start.points;
        const double volume = six_volume(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) / 6;
        const double mine = 12 * mean_of_exp(log_densities) * volume + 0.1;
        work[start.subdomain.value] += mine, total += mine, heaviest = std::max(heaviest, mine);
      }
    for (const double w : work) EXPECT_NEAR(w, total / n, heaviest);
  }
}

TEST(DistributeMemory, ARankReceivesAboutItsShare) {
  MetricMesh whole{support::unit_cube(24), {}};
  support::shuffle(whole.mesh, 2);
  whole.log_metrics.assign(whole.mesh.points.size(), meshing::identity_tensor(2));
  constexpr int kRanks = 8;
  support::run_ranks(kRanks, [&](Peers& peers) {
    support::CountingPeers counting(peers);
    distribute(counting, support::slice_of(whole, peers.rank(), kRanks), options_of(16));
    // A tet's faces are the most: 96 bytes a tet, and here each point of the shuffled tets 80 bytes.
    const std::size_t share = whole.mesh.tets.size() / kRanks;
    EXPECT_LT(counting.most, 200 * share);
  });
}

TEST(DistributeOptions, AreChecked) {
  const MetricMesh whole = support::random_metric_mesh(3);
  for (const std::uint32_t n : {0u, 0xFFFFFFu}) {
    DecompositionOptions options;
    options.num_subdomains = n;
    for (const auto& e : support::run_ranks_caught(
             3, [&](Peers& peers) { distribute(peers, support::slice_of(whole, peers.rank(), 3), options); }))
      EXPECT_THROW(std::rethrow_exception(e), std::invalid_argument) << n;
  }
}

TEST(HomeRank, SpreadsSubdomainsInOrder) {
  for (const int ranks : support::kNumbersOfRanks)
    for (const std::uint32_t n : {1u, 5u, 16u, 1000u}) {
      int last = 0;
      std::map<int, std::uint32_t> counts;
      for (SubdomainId s(0); s.value < n; ++s.value) {
        const int rank = home_rank(s, n, ranks);
        EXPECT_TRUE(rank >= last && rank < ranks);
        ++counts[last = rank];
      }
      for (const auto& [rank, count] : counts) EXPECT_LE(count, n / static_cast<std::uint32_t>(ranks) + 1);
    }
}

/// Every triangle a patch of its own, and required: no rank may hear of all of them from every other.
TEST(Distribute, NoExchangeGrowsWithRanksTimesPatches) {
  MetricMesh whole;
  whole.mesh = support::unit_cube(10);
  for (std::uint32_t t = 0; t < whole.mesh.triangles.size(); ++t) {
    whole.mesh.triangle_refs[t] = static_cast<std::int32_t>(t);
    whole.mesh.required_triangles.push_back(t);
  }
  whole.log_metrics.assign(whole.mesh.points.size(), meshing::LogMetric{});
  const auto most_on = [&](int ranks) {
    std::vector<std::size_t> most(static_cast<std::size_t>(ranks));
    support::run_ranks(ranks, [&](Peers& peers) {
      support::CountingPeers counting(peers);
      const Distributed d =
          distribute(counting, support::slice_of(whole, peers.rank(), ranks, 0), options_of(32));
      EXPECT_EQ(d.geometry->patch_inner.size(), whole.mesh.triangles.size());
      most[static_cast<std::size_t>(peers.rank())] = counting.most;
    });
    return *std::max_element(most.begin(), most.end());
  };
  EXPECT_LE(most_on(16), most_on(2));
}

/// Flat tets whose vertices are shared: all copies are marked, on whatever rank.
TEST(Distribute, DelicateVerticesAreMarkedInAllCopies) {
  MetricMesh whole;
  whole.mesh = support::unit_cube(4);
  for (meshing::Point& p : whole.mesh.points)
    if (std::abs(p.z - 0.5) < 1e-9) p.z = 0.25 + 1e-13;  // a layer that is as good as flat
  whole.log_metrics.assign(whole.mesh.points.size(), meshing::LogMetric{});
  for (const int ranks : {1, 3, 5}) {
    const Distributed d = distribute_on(ranks, whole, options_of(12));
    std::map<GlobalId, int> flag;
    std::size_t shared = 0, marked = 0;
    for (const SubdomainStart& start : d.starts)
      for (const auto& line : start.shared) {
        const int mine = start.flags[line.vertex] & kDelicate;
        EXPECT_EQ(flag.try_emplace(start.ids[line.vertex], mine).first->second, mine);
        ++shared;
        marked += mine != 0;
      }
    EXPECT_GT(marked, shared / 4);
    EXPECT_LT(marked, shared);
  }
}

}  // namespace
}  // namespace weft::partition::distribute_test
