// Fields carried between meshes in parts: what one process carries, on any number of ranks and any shares.
#include "partition/fields/transfer_in_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <utility>

#include "meshing/base/error.h"
#include "partition/fields/box_tree.h"
#include "partition/fields/part_pair.h"
#include "partition/fields/surroundings.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"
#include "tests/support/slivers.h"

namespace weft::partition::transfer_in_parts_test {
namespace {

using meshing::ComponentAccount;
using meshing::Field;
using meshing::MeshData;
using meshing::Point;
using meshing::SolutionData;
using meshing::Transfer;
using meshing::TransferMethod;

MeshData jittered(std::uint32_t n, unsigned seed) {
  MeshData mesh = support::unit_cube(n);
  support::jitter_interior(mesh, 0.2 / n, seed);
  support::shuffle(mesh, seed);
  return mesh;
}

MeshData scaled(MeshData mesh, double factor) {
  for (Point& p : mesh.points) p = {factor * p.x, factor * p.y, factor * p.z};
  return mesh;
}

/// A shock, a vector, and a definite tensor that jumps.
SolutionData fields_on(const std::vector<Point>& points) {
  SolutionData fields{
      points.size(),
      {{Field::Kind::scalar, {}, "u"}, {Field::Kind::vector, {}, "v"}, {Field::Kind::tensor, {}, "m"}}};
  for (const Point& p : points) {
    fields.fields[0].values.push_back(std::tanh(60 * (p.x + 0.3 * p.y - 0.6)));
    for (const double x : {p.x, std::sin(9 * p.y), p.z * p.x}) fields.fields[1].values.push_back(x);
    const double c = std::cos(5 * p.y), s = std::sin(5 * p.y), strong = 1 + 1e3 * std::exp(-30 * p.x);
    for (const double x :
         {strong * c * c + s * s, (strong - 1) * c * s, strong * s * s + c * c, 0.0, 0.0, 1.0})
      fields.fields[2].values.push_back(x);
  }
  return fields;
}

/// The transfer on so many ranks with shares drawn by `seed`, which are gone as soon as they are read; values
/// of the whole mesh, accounts of rank 0.
Transfer on_ranks(int ranks, unsigned seed, const MeshData& from, const MeshData& to, TransferMethod method) {
  std::vector<Transfer> of_rank(static_cast<std::size_t>(ranks));
  support::run_ranks(ranks, [&](Peers& peers) {
    MeshSlice old_slice = support::slice_of({from, {}}, peers.rank(), ranks, seed);
    MeshSlice new_slice = support::slice_of({to, {}}, peers.rank(), ranks, seed + 1);
    SolutionData fields = fields_on(old_slice.points);
    int calls = 0;
    const auto slices_are_read = [&] {
      ++calls;
      old_slice = new_slice = {};
      fields = {};
    };
    of_rank[static_cast<std::size_t>(peers.rank())] =
        transfer_in_parts(peers, old_slice, fields, new_slice, method, nullptr, slices_are_read);
    EXPECT_EQ(calls, 1);
  });
  Transfer whole = of_rank[0];
  for (int r = 1; r < ranks; ++r) {
    const Transfer& part = of_rank[static_cast<std::size_t>(r)];
    for (std::size_t f = 0; f < part.fields.fields.size(); ++f) {
      auto& values = whole.fields.fields[f].values;
      values.insert(values.end(), part.fields.fields[f].values.begin(), part.fields.fields[f].values.end());
    }
    EXPECT_EQ(part.accounts[0].integral_after, whole.accounts[0].integral_after) << "the same on all ranks";
  }
  return whole;
}

TEST(TransferInParts, InterpolatesOnAllRanksWhenOneIsInterrupted) {
  const MeshData from = jittered(5, 1), to = jittered(6, 2);
  const std::atomic<bool> interrupt{true};
  support::run_ranks(3, [&](Peers& peers) {
    const MeshSlice old_slice = support::slice_of({from, {}}, peers.rank(), 3, 1);
    const MeshSlice new_slice = support::slice_of({to, {}}, peers.rank(), 3, 2);
    const SolutionData fields = fields_on(old_slice.points);
    const auto carried = [&](TransferMethod method, const std::atomic<bool>* flag) {
      return transfer_in_parts(peers, old_slice, fields, new_slice, method, flag);
    };
    const Transfer cut = carried(TransferMethod::conservative, peers.rank() == 1 ? &interrupt : nullptr);
    const Transfer linear = carried(TransferMethod::linear, nullptr);
    EXPECT_EQ(cut.method, TransferMethod::linear);
    for (std::size_t f = 0; f < 3; ++f)
      EXPECT_EQ(cut.fields.fields[f].values, linear.fields.fields[f].values);
  });
}

/// Beside a transfer in one piece, to rounding.
void expect_same(const Transfer& result, const Transfer& expected, double tolerance) {
  ASSERT_EQ(result.fields.fields.size(), expected.fields.fields.size());
  for (std::size_t f = 0; f < expected.fields.fields.size(); ++f) {
    const auto &values = result.fields.fields[f].values, &wanted = expected.fields.fields[f].values;
    ASSERT_EQ(values.size(), wanted.size());
    EXPECT_EQ(result.fields.fields[f].name, expected.fields.fields[f].name);
    const double scale =
        std::abs(*std::ranges::max_element(wanted, {}, [](double x) { return std::abs(x); }));
    for (std::size_t i = 0; i < values.size(); ++i) ASSERT_NEAR(values[i], wanted[i], tolerance * scale) << i;
  }
  EXPECT_EQ(result.outside, expected.outside);
  EXPECT_NEAR(result.farthest, expected.farthest, 1e-12);
  ASSERT_EQ(result.accounts.size(), expected.accounts.size());
  for (std::size_t c = 0; c < expected.accounts.size(); ++c) {
    const ComponentAccount &a = result.accounts[c], &b = expected.accounts[c];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.stays_definite, b.stays_definite);
    EXPECT_NEAR(a.integral_before, b.integral_before, 1e-12 * b.absolute);
    EXPECT_NEAR(a.integral_after, b.integral_after, tolerance * b.absolute);
    EXPECT_NEAR(a.absolute, b.absolute, 1e-12 * b.absolute);
    EXPECT_NEAR(a.norm_l2, b.norm_l2, 1e-10 * b.norm_l2);
    EXPECT_NEAR(a.norm_max, b.norm_max, 0);
    EXPECT_NEAR(a.difference_l2, b.difference_l2, tolerance * b.norm_l2);
    EXPECT_NEAR(a.difference_max, b.difference_max, tolerance * b.norm_max);
    EXPECT_NEAR(a.beyond_bounds, b.beyond_bounds, tolerance * b.norm_max);
  }
}

/// Fine at the origin.
MeshData graded(std::uint32_t n, double power) {
  MeshData mesh = support::unit_cube(n);
  for (Point& p : mesh.points) p = {std::pow(p.x, power), std::pow(p.y, power), std::pow(p.z, power)};
  return mesh;
}

TEST(PartPair, OfGradedMeshesHasLittleMoreThanOverlaps) {
  constexpr int kRanks = 6;
  const MeshData from = graded(12, 4), to = graded(20, 5);
  std::vector<double> onto_new(kRanks);
  support::run_ranks(kRanks, [&](Peers& peers) {
    const auto me = static_cast<std::size_t>(peers.rank());
    const PartPair meshes(peers, support::slice_of({from, {}}, peers.rank(), kRanks, 1),
                          support::slice_of({to, {}}, peers.rank(), kRanks, 2));
    onto_new[me] = static_cast<double>(meshes.source().tets.size());
  });
  const auto sum = [](const std::vector<double>& of_rank) {
    return std::accumulate(of_rank.begin(), of_rank.end(), 0.0);
  };
  EXPECT_LT(sum(onto_new), 2.5 * static_cast<double>(from.tets.size()));
  EXPECT_LT(std::ranges::max(onto_new), 0.6 * static_cast<double>(from.tets.size()));
}

TEST(BoxesOfTets, AreFewAndHaveAllTets) {
  const MeshData mesh = graded(12, 4);
  for (const std::size_t most : {1, 2, 100, 2000, 100'000}) {
    const std::vector<meshing::Box> boxes = boxes_of_tets(mesh, most);
    EXPECT_LE(boxes.size(), 2 * most);
    const auto inside = [](const meshing::Box& box, const meshing::Box& other) {
      meshing::Box both = other;
      both.unite(box);
      return both.lo == other.lo && both.hi == other.hi;
    };
    for (const meshing::Tet& tet : mesh.tets) {
      const meshing::Box box = box_of(mesh, tet);
      EXPECT_TRUE(std::ranges::any_of(boxes, [&](const auto& b) { return inside(box, b); }));
    }
  }
}

TEST(BoxTree, MeetsWhatAnyBoxMeets) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(0, 1), side(0, 0.2);
  const auto random_box = [&] {
    const Point lo{at(random), at(random), at(random)};
    return meshing::Box{lo, lo + meshing::Vec{side(random), side(random), side(random)}};
  };
  for (std::size_t count = 0; count < 40; ++count) {
    std::vector<meshing::Box> boxes(count);
    std::ranges::generate(boxes, random_box);
    BoxTree tree(boxes);
    for (int i = 0; i < 200; ++i) {
      const meshing::Box box = random_box();
      EXPECT_EQ(tree.meets(box), std::ranges::any_of(boxes, [&](const auto& b) { return b.meets(box); }));
    }
  }
}

class TransferInParts : public testing::TestWithParam<int> {};

TEST_P(TransferInParts, IsThatOfOneProcess) {
  const std::pair<MeshData, MeshData> pairs[] = {{jittered(6, 1), jittered(9, 2)},
                                                 {jittered(9, 1), jittered(4, 2)},
                                                 {support::ball(1, 3), support::ball(2, 4)}};
  unsigned seed = 0;
  for (const auto& [from, to] : pairs)
    for (const TransferMethod method : {TransferMethod::linear, TransferMethod::conservative})
      expect_same(on_ranks(GetParam(), seed++, from, to, method),
                  meshing::transfer(from, fields_on(from.points), to, method), 1e-9);
}

TEST_P(TransferInParts, HasTheBitsOfOneRank) {
  // Structured meshes have vertices on each other's faces and edges, so that tets are not unique; turned they
  // have them there but for rounding.
  const std::pair<MeshData, MeshData> pairs[] = {
      {support::unit_cube(4), support::unit_cube(6)},
      {jittered(6, 1), jittered(9, 2)},
      {support::ball(1, 3), support::ball(2, 4)},
      {support::with_slivers(support::turned(jittered(6, 1)), 1),
       support::with_slivers(support::turned(support::unit_cube(7)), 2)}};
  for (const auto& [from, to] : pairs)
    for (const TransferMethod method : {TransferMethod::linear, TransferMethod::conservative}) {
      const Transfer one = on_ranks(1, 0, from, to, method), many = on_ranks(GetParam(), 7, from, to, method);
      for (std::size_t f = 0; f < one.fields.fields.size(); ++f)
        EXPECT_EQ(many.fields.fields[f].values, one.fields.fields[f].values);
    }
}

TEST_P(TransferInParts, KeepsIntegrals) {
  const MeshData from = jittered(7, 1), to = jittered(8, 2);
  const Transfer result = on_ranks(GetParam(), 3, from, to, TransferMethod::conservative);
  double trace = 0;
  for (const int c : {4, 6, 9}) trace += result.accounts[static_cast<std::size_t>(c)].absolute;
  for (std::size_t c = 0; c < result.accounts.size(); ++c) {
    const ComponentAccount& a = result.accounts[c];
    EXPECT_LE(std::abs(a.integral_after - a.integral_before), 1e-12 * (c < 4 ? a.absolute : trace)) << a.name;
  }
}

/// Most points lie far from what their ranks have first.
TEST_P(TransferInParts, FindsTheClosestPointHoweverFar) {
  const MeshData from = jittered(5, 1), to = scaled(jittered(6, 2), 4);
  expect_same(on_ranks(GetParam(), 5, from, to, TransferMethod::linear),
              meshing::transfer(from, fields_on(from.points), to, TransferMethod::linear), 1e-9);
}

TEST_P(TransferInParts, RefusesMeshesWithoutTets) {
  MeshData points = support::unit_cube(2);
  points.tets.clear();
  points.tet_refs.clear();
  const MeshData good = support::unit_cube(2);
  EXPECT_THROW(on_ranks(GetParam(), 0, points, good, TransferMethod::linear), meshing::InputError);
  EXPECT_THROW(on_ranks(GetParam(), 0, good, points, TransferMethod::linear), meshing::NewMeshError);
}

TEST_P(TransferInParts, AllRanksRefuseANewMeshWithAFaceOfThreeTets) {
  const MeshData good = support::unit_cube(3);
  MeshData doubled = support::unit_cube(2);
  doubled.tets.push_back(doubled.tets[0]);
  doubled.tet_refs.push_back(doubled.tet_refs[0]);
  const int ranks = GetParam();
  const auto thrown = support::run_ranks_caught(ranks, [&](Peers& peers) {
    const MeshSlice from = support::slice_of({good, {}}, peers.rank(), ranks, 1);
    const MeshSlice to = support::slice_of({doubled, {}}, peers.rank(), ranks, 2);
    transfer_in_parts(peers, from, fields_on(from.points), to, TransferMethod::linear);
  });
  for (const std::exception_ptr& of_rank : thrown) {
    ASSERT_TRUE(of_rank);
    EXPECT_THROW(std::rethrow_exception(of_rank), meshing::NewMeshError);
  }
}

INSTANTIATE_TEST_SUITE_P(Ranks, TransferInParts, testing::ValuesIn(support::kNumbersOfRanks));

}  // namespace
}  // namespace weft::partition::transfer_in_parts_test
