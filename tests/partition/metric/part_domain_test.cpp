// Metrics made in parts: of sources the bits of the whole mesh, of limits and scales those of one rank.
#include "partition/metric/part_domain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "meshing/base/error.h"
#include "meshing/metric/gradation.h"
#include "meshing/metric/metric_limits.h"
#include "meshing/metric/sources/implied_metric.h"
#include "meshing/metric/sources/multiscale.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::partition::part_domain_test {
namespace {

using meshing::HessianRecovery;
using meshing::LogMetricField;
using meshing::MeshData;
using meshing::MetricDomain;

using Make = std::function<LogMetricField(const MetricDomain&, const std::vector<double>& values)>;

/// A box whose vertices are numbered at random, so that shares of the file lie everywhere; one vertex has no
/// tets.
MeshData shuffled_box() {
  MeshData mesh = support::layered_box(5, 5, 2);
  std::vector<std::uint32_t> numbers(mesh.points.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  std::shuffle(numbers.begin(), numbers.end(), std::mt19937(7));
  MeshData shuffled = mesh;
  for (std::size_t v = 0; v < numbers.size(); ++v) shuffled.points[numbers[v]] = mesh.points[v];
  for (auto& tet : shuffled.tets)
    for (std::uint32_t& v : tet) v = numbers[v];
  shuffled.points.push_back({0.5, 0.5, 0.5});
  shuffled.point_refs.push_back(0);
  for (auto* list : {&shuffled.triangles})
    for (auto& triangle : *list)
      for (std::uint32_t& v : triangle) v = numbers[v];
  for (auto& edge : shuffled.edges)
    for (std::uint32_t& v : edge) v = numbers[v];
  shuffled.corners.clear();
  return shuffled;
}

std::vector<double> layer(const MeshData& mesh) {
  std::vector<double> values;
  for (const auto& p : mesh.points) values.push_back(std::tanh(8 * (p.x + 0.3 * p.y - 0.6)) + p.z * p.z);
  return values;
}

/// make() on so many ranks, and shares by `seed`; at the vertices of the whole mesh.
LogMetricField made_on(int ranks, unsigned seed, int rings, const Make& make) {
  support::MetricMesh whole{shuffled_box(), {}};
  const std::vector<double> values = layer(whole.mesh);
  std::vector<LogMetricField> of_rank(static_cast<std::size_t>(ranks));
  support::run_ranks(ranks, [&](Peers& peers) {
    const MeshSlice slice = support::slice_of(whole, peers.rank(), ranks, seed);
    const PartDomain domain(peers, slice, rings);
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(slice.first_point);
    const std::vector<double> of_slice(first, first + static_cast<std::ptrdiff_t>(slice.points.size()));
    of_rank[static_cast<std::size_t>(peers.rank())] =
        domain.to_slices(make(domain, domain.from_slices(of_slice)));
  });
  LogMetricField all;
  for (const LogMetricField& field : of_rank) all.insert(all.end(), field.begin(), field.end());
  return all;
}

LogMetricField made_of_the_whole(const Make& make) {
  const MeshData mesh = shuffled_box();
  return make(meshing::WholeDomain(mesh), layer(mesh));
}

void expect_bits_of_the_whole(int rings, const Make& make) {
  const LogMetricField whole = made_of_the_whole(make);
  for (const int ranks : support::kNumbersOfRanks)
    for (const unsigned seed : {0u, 5u})
      EXPECT_EQ(made_on(ranks, seed, rings, make), whole) << ranks << " ranks";
}

/// The same bits on all numbers of ranks, and to rounding those of the whole mesh.
void expect_same_everywhere(int rings, const Make& make) {
  const LogMetricField whole = made_of_the_whole(make);
  const LogMetricField one = made_on(1, 0, rings, make);
  ASSERT_EQ(one.size(), whole.size());
  for (std::size_t v = 0; v < one.size(); ++v)
    EXPECT_LT(std::abs(trace(one[v] - whole[v])), 1e-6) << "vertex " << v;
  for (const int ranks : support::kNumbersOfRanks)
    EXPECT_EQ(made_on(ranks, 3, rings, make), one) << ranks << " ranks";
}

LogMetricField multiscale(const MetricDomain& domain, const std::vector<double>& values,
                          HessianRecovery recovery) {
  return meshing::multiscale_metric(domain, values, {recovery, 2});
}

TEST(PartDomain, HasTheMultiscaleMetricOfTheWholeMeshToTheBit) {
  for (const auto recovery : {HessianRecovery::least_squares, HessianRecovery::double_projection})
    expect_bits_of_the_whole(
        meshing::rings_of(recovery),
        [&](const MetricDomain& domain, const auto& values) { return multiscale(domain, values, recovery); });
}

TEST(PartDomain, HasTheImpliedMetricOfTheWholeMeshToTheBit) {
  expect_bits_of_the_whole(
      1, [](const MetricDomain& domain, const auto&) { return meshing::implied_metric(domain); });
}

TEST(PartDomain, GradesAsTheWholeMeshToTheBit) {
  for (const auto space : {meshing::GradationSpace::metric, meshing::GradationSpace::mixed})
    expect_bits_of_the_whole(4, [&](const MetricDomain& domain, const auto& values) {
      LogMetricField field = multiscale(domain, values, HessianRecovery::least_squares);
      meshing::apply_limits(domain, {0.001, 1, 50, 1.2, space}, field);
      return field;
    });
}

TEST(PartDomain, MeetsTheComplexityUnderLimitsAlikeOnAnyRanks) {
  for (const double gradation : {0.0, 1.4})
    expect_same_everywhere(4, [&](const MetricDomain& domain, const auto& values) {
      LogMetricField field = multiscale(domain, values, HessianRecovery::least_squares);
      const LogMetricField demands(field.size(), meshing::identity_tensor(-2 * std::log(0.4)));
      const double reached = meshing::fit_to_complexity(
          domain, 800, {0.01, 0.5, 20, gradation, meshing::GradationSpace::metric}, &demands, field);
      EXPECT_NEAR(reached, 800, 8);
      return field;
    });
  expect_same_everywhere(4, [&](const MetricDomain& domain, const auto& values) {
    LogMetricField field = multiscale(domain, values, HessianRecovery::least_squares);
    meshing::scale_to_complexity(domain, 800, 0.02, 0.3, field);
    return field;
  });
}

TEST(PartDomain, EndsGradationOnAllRanksWhenOneIsInterrupted) {
  const support::MetricMesh whole{shuffled_box(), {}};
  const std::atomic<bool> interrupt{true};
  support::run_ranks(3, [&](Peers& peers) {
    const MeshSlice slice = support::slice_of(whole, peers.rank(), 3, 1);
    const PartDomain domain(peers, slice, 1, peers.rank() == 1 ? &interrupt : nullptr);
    LogMetricField field = domain.from_slices(LogMetricField(slice.points.size()));
    for (std::size_t v = 0; v < field.size(); ++v)
      if (domain.numbers()[v] == 0) field[v] = meshing::identity_tensor(std::log(1e4));
    const meshing::Gradation gradation(domain, 1.2, meshing::GradationSpace::metric);
    EXPECT_EQ(gradation.limit(field), 1);
    EXPECT_TRUE(domain.interrupted());
    EXPECT_EQ(domain.interrupted_here(), peers.rank() == 1);
  });
}

TEST(PartDomain, RefusesAnInvertedTetOnAllRanksAlike) {
  support::MetricMesh whole{shuffled_box(), {}};
  std::swap(whole.mesh.tets[70][0], whole.mesh.tets[70][1]);
  for (const int ranks : support::kNumbersOfRanks) {
    const auto thrown = support::run_ranks_caught(
        ranks, [&](Peers& peers) { PartDomain(peers, support::slice_of(whole, peers.rank(), ranks), 2); });
    for (const std::exception_ptr& e : thrown) {
      ASSERT_TRUE(e);
      try {
        std::rethrow_exception(e);
      } catch (const meshing::InputError& error) {
        EXPECT_NE(std::string(error.what()).find("tet 71 "), std::string::npos) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace weft::partition::part_domain_test
