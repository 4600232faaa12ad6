// Tests of the transfer of fields: conservation, exactness, bounds, account.
#include "meshing/fields/transfer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

#include "meshing/base/error.h"
#include "meshing/fields/interpolate.h"
#include "meshing/metric/metric.h"
#include "tests/support/meshes.h"

namespace weft::meshing::transfer_test {
namespace {

using support::unit_cube;
constexpr TransferMethod kBoth[] = {TransferMethod::linear, TransferMethod::conservative};

MeshData jittered(std::uint32_t n, unsigned seed) {
  MeshData mesh = unit_cube(n);
  support::jitter_interior(mesh, 0.2 / n, seed);
  support::shuffle(mesh, seed);
  return mesh;
}

SolutionData scalar(const MeshData& mesh, const std::function<double(const Point&)>& u) {
  SolutionData solution{mesh.points.size(), {{Field::Kind::scalar, {}, "u"}}};
  for (const Point& p : mesh.points) solution.fields[0].values.push_back(u(p));
  return solution;
}

double shock(const Point& p) { return std::tanh(60 * (p.x + 0.3 * p.y - 0.6)); }

/// A scalar, a vector and a tensor field, all linear.
SolutionData linear_fields(const MeshData& mesh) {
  SolutionData solution{
      mesh.points.size(),
      {{Field::Kind::scalar, {}, "s"}, {Field::Kind::vector, {}, "v"}, {Field::Kind::tensor, {}, "t"}}};
  for (const Point& p : mesh.points)
    for (Field& field : solution.fields)
      for (int c = 0; c < components(field.kind); ++c)
        field.values.push_back(c + p.x - (c + 1) * p.y + 0.3 * p.z);
  return solution;
}

void expect_conserved(const Transfer& result) {
  for (const ComponentAccount& a : result.accounts)
    EXPECT_LE(std::abs(a.integral_after - a.integral_before), 1e-12 * a.absolute) << a.name;
}

TEST(Transfer, IsExactForLinearFieldsOfEveryKind) {
  for (const TransferMethod method : kBoth)
    for (const auto& [n, m] : {std::pair{5u, 7u}, {7u, 3u}, {4u, 4u}}) {
      const MeshData from = jittered(n, 1), to = jittered(m, 2);
      const Transfer result = transfer(from, linear_fields(from), to, method);
      const SolutionData exact = linear_fields(to);
      ASSERT_EQ(result.accounts.size(), 10);
      EXPECT_EQ(result.accounts[1].name, "v 1");
      expect_conserved(result);
      for (std::size_t f = 0; f < 3; ++f)
        for (std::size_t i = 0; i < exact.fields[f].values.size(); ++i)
          EXPECT_NEAR(result.fields.fields[f].values[i], exact.fields[f].values[i], 1e-11);
      for (const ComponentAccount& a : result.accounts) EXPECT_LT(a.difference_l2 / a.norm_l2, 1e-11);
    }
}

TEST(Transfer, InterpolatesOnceItIsInterrupted) {
  const MeshData from = jittered(5, 1), to = jittered(4, 2);
  const SolutionData fields = scalar(from, shock);
  const std::atomic<bool> interrupt{true}, no_interrupt{false};
  const Transfer linear = transfer(from, fields, to, TransferMethod::linear);
  const Transfer whole = transfer(from, fields, to, TransferMethod::conservative, &no_interrupt);
  const Transfer cut = transfer(from, fields, to, TransferMethod::conservative, &interrupt);
  EXPECT_EQ(linear.method, TransferMethod::linear);
  EXPECT_EQ(whole.method, TransferMethod::conservative);
  EXPECT_EQ(cut.method, TransferMethod::linear);
  EXPECT_EQ(cut.fields.fields[0].values, linear.fields.fields[0].values);
  EXPECT_NE(whole.fields.fields[0].values, linear.fields.fields[0].values);
  EXPECT_EQ(cut.accounts[0].integral_after, linear.accounts[0].integral_after);
}

TEST(Transfer, ConservesAShockWithoutNewExtremes) {
  for (const auto& [n, m] : {std::pair{6u, 11u}, {11u, 4u}, {8u, 8u}}) {
    const MeshData from = jittered(n, 3), to = jittered(m, 4);
    const SolutionData fields = scalar(from, shock);
    const Transfer result = transfer(from, fields, to, TransferMethod::conservative);
    expect_conserved(result);
    EXPECT_LT(result.accounts[0].beyond_bounds, 1e-13);
    const auto [lo, hi] = std::ranges::minmax(fields.fields[0].values);
    for (const double u : result.fields.fields[0].values) {
      EXPECT_GE(u, lo - 1e-13);
      EXPECT_LE(u, hi + 1e-13);
    }
    const Transfer linear = transfer(from, fields, to, TransferMethod::linear);
    EXPECT_GT(std::abs(linear.accounts[0].integral_after - linear.accounts[0].integral_before), 1e-6);
  }
}

TEST(Transfer, ToTheSameMeshChangesNothing) {
  const MeshData mesh = jittered(6, 5);
  const SolutionData fields = scalar(mesh, [](const Point& p) { return std::sin(300 * p.x * p.y + p.z); });
  for (const TransferMethod method : kBoth) {
    const Transfer result = transfer(mesh, fields, mesh, method);
    for (std::size_t i = 0; i < fields.num_points; ++i)
      EXPECT_NEAR(result.fields.fields[0].values[i], fields.fields[0].values[i], 1e-10);
    EXPECT_LT(result.accounts[0].difference_max, 1e-10);
  }
}

TEST(Transfer, FieldsThatStayHaveTheAccountOfATransferToTheSameMesh) {
  const MeshData mesh = jittered(4, 5);
  SolutionData fields = linear_fields(mesh);
  for (double& value : fields.fields[0].values) value = std::sin(30 * value);
  fields.fields.push_back({Field::Kind::tensor, {}, "m"});
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    for (const double entry : {2.0, 0.1, 1.0, 0.2, 0.0, 3.0}) fields.fields[3].values.push_back(entry);
  for (const TransferMethod method : kBoth) {
    const Transfer kept = keep_fields(WholeDomain(mesh), fields, method);
    const Transfer carried = transfer(mesh, fields, mesh, method);
    EXPECT_EQ(kept.method, method);
    ASSERT_EQ(kept.accounts.size(), carried.accounts.size());
    for (std::size_t f = 0; f < fields.fields.size(); ++f)
      EXPECT_EQ(kept.fields.fields[f].values, fields.fields[f].values);
    for (std::size_t c = 0; c < kept.accounts.size(); ++c) {
      const ComponentAccount &a = kept.accounts[c], &b = carried.accounts[c];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.integral_before, b.integral_before);
      EXPECT_EQ(a.integral_after, a.integral_before);
      EXPECT_EQ(a.absolute, b.absolute);
      EXPECT_EQ(a.norm_l2, b.norm_l2);
      EXPECT_EQ(a.norm_max, b.norm_max);
      EXPECT_EQ(a.difference_max, 0);
      EXPECT_EQ(a.difference_l2, 0);
      EXPECT_EQ(a.stays_definite, b.stays_definite);
    }
  }
}

/// A metric that jumps from 1:1 to 1:100 within a cell, its axes turning.
SolutionData layer_metric(const MeshData& mesh) {
  SolutionData solution{mesh.points.size(), {{Field::Kind::scalar, {}, "u"}, {Field::Kind::tensor, {}, "m"}}};
  for (const Point& p : mesh.points) {
    solution.fields[0].values.push_back(shock(p));
    const double c = std::cos(5 * p.y), s = std::sin(5 * p.y), strong = 1 + 1e4 * std::exp(-30 * p.x);
    for (const double entry :
         {strong * c * c + s * s, (strong - 1) * c * s, strong * s * s + c * c, 0.0, 0.0, 1.0})
      solution.fields[1].values.push_back(entry);
  }
  return solution;
}

SymTensor tensor_at(const Field& field, std::size_t v) {
  const double* t = field.values.data() + 6 * v;
  return {t[0], t[1], t[2], t[3], t[4], t[5]};
}

TEST(Transfer, KeepsMetricsDefiniteAndTheirIntegrals) {
  for (const auto& [n, m] : {std::pair{5u, 9u}, {9u, 4u}, {6u, 6u}}) {
    const MeshData from = jittered(n, 3), to = jittered(m, 4);
    const SolutionData fields = layer_metric(from);
    const Transfer result = transfer(from, fields, to, TransferMethod::conservative);
    double trace = 0, largest = 0;
    for (const int c : {1, 3, 6}) trace += result.accounts[static_cast<std::size_t>(c)].absolute;
    for (std::size_t c = 1; c < 7; ++c) {
      const ComponentAccount& a = result.accounts[c];
      EXPECT_TRUE(a.stays_definite);
      EXPECT_LE(std::abs(a.integral_after - a.integral_before), 1e-12 * trace) << a.name;
      EXPECT_LE(a.beyond_bounds, 1e-12 * a.norm_max);  // the volumes are the same
      largest = std::max(largest, a.norm_max);
    }
    EXPECT_FALSE(result.accounts[0].stays_definite);
    for (std::size_t v = 0; v < to.points.size(); ++v) {
      const Eigen3 e = eigen_decomposition(tensor_at(result.fields.fields[1], v));
      EXPECT_GE(e.values[0], 1 - 1e-9 * largest);  // the least eigenvalue of all
      EXPECT_LE(e.values[2], 2 * largest);
    }
  }
}

TEST(Transfer, KeepsAMetricOnTheSameMesh) {
  const MeshData mesh = jittered(6, 5);
  const SolutionData fields = layer_metric(mesh);
  const Transfer result = transfer(mesh, fields, mesh, TransferMethod::conservative);
  for (std::size_t i = 0; i < fields.fields[1].values.size(); ++i)
    EXPECT_NEAR(result.fields.fields[1].values[i], fields.fields[1].values[i], 1e-9 * 1e4);
}

TEST(Transfer, KeepsMetricsDefiniteWhereTheVolumesDiffer) {
  const MeshData from = support::ball(1, 3), to = support::ball(2, 4);
  const Transfer result = transfer(from, layer_metric(from), to, TransferMethod::conservative);
  double trace = 0;
  for (const int c : {1, 3, 6}) trace += result.accounts[static_cast<std::size_t>(c)].absolute;
  for (std::size_t c = 1; c < 7; ++c) {
    const ComponentAccount& a = result.accounts[c];
    EXPECT_LE(std::abs(a.integral_after - a.integral_before), 1e-12 * trace) << a.name;
  }
  EXPECT_GT(result.accounts[1].beyond_bounds, 0.01);
  for (std::size_t v = 0; v < to.points.size(); ++v)
    EXPECT_TRUE(is_positive_definite(tensor_at(result.fields.fields[1], v)));
}

TEST(Transfer, OfThinCellsConserves) {
  MeshData from = jittered(6, 6), to = jittered(7, 7);
  for (MeshData* mesh : {&from, &to})
    for (Point& p : mesh->points) p.x = 1e-5 * p.x + 3;
  const auto layer = [](const Point& p) { return std::exp(-(p.x - 3) * 4e5) + 1e-3 * p.y; };
  expect_conserved(transfer(from, scalar(from, layer), to, TransferMethod::conservative));
}

TEST(Transfer, KeepsTheIntegralWhereTheVolumesDiffer) {
  const MeshData from = support::ball(1, 3), to = support::ball(2, 4);  // polyhedra of different volumes
  const Transfer constant =
      transfer(from, scalar(from, [](const Point&) { return 2.0; }), to, TransferMethod::conservative);
  expect_conserved(constant);
  EXPECT_GT(constant.accounts[0].beyond_bounds, 0.01);
  const Transfer bump = transfer(from, scalar(from, [](const Point& p) { return std::exp(-9 * norm2(p)); }),
                                 to, TransferMethod::conservative);
  expect_conserved(bump);
  EXPECT_LT(bump.accounts[0].beyond_bounds, 1e-13);
  EXPECT_GT(bump.outside, 0);
}

TEST(Transfer, ConservesBetweenPartsThatAreNotConnected) {
  MeshData from = support::unit_cube(2), other = support::unit_cube(2);
  const auto n = static_cast<std::uint32_t>(from.points.size());
  for (const Point& p : other.points) from.points.push_back(p + Vec{1, 0, 0});
  for (auto tet : other.tets) {
    for (std::uint32_t& v : tet) v += n;
    from.tets.push_back(tet);
  }
  BoxOptions box;
  box.cells = {3, 2, 2};  // its middle cells reach into both parts
  box.max = {2, 1, 1};
  const MeshData to = structured_box(box);
  const Transfer result = transfer(from, scalar(from, shock), to, TransferMethod::conservative);
  expect_conserved(result);
  EXPECT_LT(result.accounts[0].beyond_bounds, 1e-13);
}

TEST(Transfer, AccountsForWhatInterpolationLoses) {
  const MeshData fine = jittered(10, 8), coarse = unit_cube(2);
  const SolutionData wave = scalar(fine, [](const Point& p) { return std::sin(20 * p.x); });
  for (const TransferMethod method : kBoth) {
    const ComponentAccount a = transfer(fine, wave, coarse, method).accounts[0];
    EXPECT_GT(a.difference_l2, 0.3 * a.norm_l2);
    EXPECT_LE(a.difference_l2, 2 * a.norm_l2);
    EXPECT_GT(a.difference_max, 0.3);
    EXPECT_NEAR(a.norm_max, 1, 0.02);
  }
}

TEST(Transfer, DoesNotDependOnTheThreads) {
  const MeshData from = jittered(7, 1), to = jittered(9, 2);
  const SolutionData fields = scalar(from, shock);
  const Transfer expected = transfer(from, fields, to, TransferMethod::conservative);
  for (const int threads : {1, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(transfer(from, fields, to, TransferMethod::conservative).fields.fields[0].values,
              expected.fields.fields[0].values);
  }
}

TEST(Transfer, RefusesMeshesWithoutVolume) {
  MeshData flat = unit_cube(2);
  std::swap(flat.tets[2][0], flat.tets[2][1]);
  const MeshData good = unit_cube(1);
  for (const TransferMethod method : kBoth) {
    EXPECT_THROW(transfer(flat, linear_fields(flat), good, method), InputError);
    EXPECT_THROW(transfer(good, linear_fields(good), flat, method), NewMeshError);
    EXPECT_THROW(transfer(good, linear_fields(good), {}, method), NewMeshError);
  }
}

TEST(Transfer, SaysWhichMeshHasAFaceOfThreeTets) {
  const MeshData good = unit_cube(1);
  MeshData doubled = good;
  doubled.tets.push_back(doubled.tets[0]);
  doubled.tet_refs.push_back(doubled.tet_refs[0]);
  EXPECT_THROW(transfer(good, linear_fields(good), doubled, TransferMethod::linear), NewMeshError);
  try {
    transfer(doubled, linear_fields(doubled), good, TransferMethod::linear);
    FAIL();
  } catch (const NewMeshError&) {
    FAIL();
  } catch (const InputError&) {
  }
}

}  // namespace
}  // namespace weft::meshing::transfer_test
