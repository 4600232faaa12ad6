// Tests of the recovery of Hessians.
#include "meshing/metric/sources/hessian.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>
#include <random>

#include "meshing/mesh/adjacency.h"
#include "meshing/metric/sources/quadratic_fit.h"
#include "tests/support/meshes.h"

namespace weft::meshing::hessian_test {
namespace {

using support::unit_cube;

/// c + g.x + x.H.x / 2 with random coefficients in [-1, 1].
struct Quadratic {
  double c;
  Vec g;
  SymTensor h;
  explicit Quadratic(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-1, 1);
    c = u(random), g = {u(random), u(random), u(random)};
    h = {u(random), u(random), u(random), u(random), u(random), u(random)};
  }
  double operator()(const Point& p) const { return c + dot(g, p) + 0.5 * squared_length(h, p); }
};

template <class F>
std::vector<double> values_of(const MeshData& mesh, const F& f) {
  std::vector<double> values;
  for (const Point& p : mesh.points) values.push_back(f(p));
  return values;
}

/// The largest difference of entries.
double difference(const SymTensor& a, const SymTensor& b) {
  const SymTensor d = a - b;
  return std::max(
      {std::abs(d.xx), std::abs(d.xy), std::abs(d.yy), std::abs(d.xz), std::abs(d.yz), std::abs(d.zz)});
}

/// The largest difference over the vertices where `counts`.
template <class Counts>
double worst_difference(const MeshData& mesh, const std::vector<SymTensor>& found, const SymTensor& exact,
                        const Counts& counts) {
  double worst = 0;
  for (std::size_t v = 0; v < found.size(); ++v)
    if (counts(mesh.points[v])) worst = std::max(worst, difference(found[v], exact));
  return worst;
}

bool anywhere(const Point&) { return true; }

TEST(HessianLeastSquares, IsExactForQuadraticsOnRandomMeshes) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    MeshData mesh = unit_cube(3 + seed);
    support::jitter_interior(mesh, 0.25 / (3 + seed), seed);
    support::shuffle(mesh, seed);
    const Quadratic f(seed);
    const auto found = recover_hessians(mesh, values_of(mesh, f), HessianRecovery::least_squares);
    EXPECT_LT(worst_difference(mesh, found, f.h, anywhere), 1e-10) << "seed " << seed;  // at the boundary too
  }
}

TEST(HessianLeastSquares, IsExactForQuadraticsOnThinMeshes) {
  // Layers 1e5 times wider than thick; entries are judged in the units that each direction has.
  MeshData mesh = unit_cube(6);
  support::jitter_interior(mesh, 0.03);
  const double thin = 1e-5;
  const Quadratic f(3);
  const auto values = values_of(mesh, f);
  for (Point& p : mesh.points) p.z *= thin;
  for (const SymTensor& h : recover_hessians(mesh, values, HessianRecovery::least_squares)) {
    const SymTensor back{h.xx, h.xy, h.yy, h.xz * thin, h.yz * thin, h.zz * thin * thin};
    EXPECT_LT(difference(back, f.h), 1e-9);
  }
}

TEST(HessianLeastSquares, WorksOnMeshesWithTooFewVertices) {
  for (const MeshData& mesh : {support::regular_tet(), support::two_tets(), unit_cube(1)}) {
    const Quadratic f(5);
    for (const SymTensor& h : recover_hessians(mesh, values_of(mesh, f), HessianRecovery::least_squares))
      EXPECT_TRUE(std::isfinite(trace(h) + h.xy + h.xz + h.yz));
    const auto constant = std::vector<double>(mesh.points.size(), 7.0);
    for (const SymTensor& h : recover_hessians(mesh, constant, HessianRecovery::least_squares))
      EXPECT_EQ(difference(h, {}), 0);
  }
}

TEST(HessianLeastSquares, IsExactForQuadraticsAcrossOneLayerOfCells) {
  // Two vertices across the layer cannot tell a second derivative across it: wider balls do not help, and all
  // other entries come from the fit of least norm.
  MeshData mesh = unit_cube(6);
  std::erase_if(mesh.tets, [&](const auto& tet) {
    return std::ranges::any_of(tet, [&](std::uint32_t v) { return mesh.points[v].z > 0.2; });
  });
  const auto along = [](const Point& p) { return p.x * p.x - 0.5 * p.x * p.y; };
  const auto found = recover_hessians(mesh, values_of(mesh, along), HessianRecovery::least_squares);
  for (std::size_t v = 0; v < found.size(); ++v) {
    if (mesh.points[v].z > 0.2) continue;
    EXPECT_LT(difference(found[v], {2, -0.5, 0, 0, 0, found[v].zz}), 1e-9);
  }
}

/// The vertices on the rim do not see each other across the hub: k balls of k vertices each.
TEST(HessianLeastSquares, StaysNearWhereManyTetsMeet) {
  constexpr std::uint32_t kRim = 600;
  std::vector<Point> points{{0, 0, 0}, {0, 0, 1}, {0, 0, 2}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i < kRim; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRim;
    points.push_back({std::cos(angle), std::sin(angle), 1 + 0.1 * std::sin(5 * angle)});
    for (const std::uint32_t k : {0u, 1u}) tets.push_back({k, k + 1, 3 + i, 3 + (i + 1) % kRim});
  }
  const MeshData mesh = support::mesh_of(std::move(points), std::move(tets));
  std::vector<double> values = values_of(mesh, Quadratic(1));
  const auto before = recover_hessians(mesh, values, HessianRecovery::least_squares);
  values[3 + kRim / 2] += 1;
  const auto after = recover_hessians(mesh, values, HessianRecovery::least_squares);
  EXPECT_EQ(after[3], before[3]);
  EXPECT_FALSE(after[3 + kRim / 2] == before[3 + kRim / 2]);
}

TEST(HessianLeastSquares, ConvergesOnSmoothFields) {
  const auto f = [](const Point& p) { return std::sin(2 * p.x) * std::cos(p.y) + std::exp(p.z); };
  double last = 0;
  for (const std::uint32_t n : {6u, 12u, 24u}) {
    MeshData mesh = unit_cube(n);
    support::jitter_interior(mesh, 0.2 / n);
    const auto found = recover_hessians(mesh, values_of(mesh, f), HessianRecovery::least_squares);
    double worst = 0;
    for (std::size_t v = 0; v < found.size(); ++v) {
      const Point& p = mesh.points[v];
      worst = std::max(worst, std::abs(found[v].xx + 4 * std::sin(2 * p.x) * std::cos(p.y)));
    }
    if (last > 0) {
      EXPECT_LT(worst, 0.65 * last);  // first order, at the boundary too
    }
    last = worst;
  }
}

TEST(HessianDoubleProjection, IsExactForQuadraticsWhereTheMeshRepeats) {
  const MeshData mesh = unit_cube(16);
  const Quadratic f(2);
  const auto found = recover_hessians(mesh, values_of(mesh, f), HessianRecovery::double_projection);
  // The box is mirrored at its middle planes. Two edges from those and the boundary all balls are alike and
  // symmetric about their centres, so that the errors of the tets' gradients cancel.
  const auto deep_in_an_octant = [](double x) { return std::abs(std::abs(x - 0.5) - 0.25) < 2.5 / 16; };
  EXPECT_LT(worst_difference(mesh, found, f.h,
                             [&](const Point& p) {
                               return deep_in_an_octant(p.x) && deep_in_an_octant(p.y) &&
                                      deep_in_an_octant(p.z);
                             }),
            1e-10);
}

TEST(HessianDoubleProjection, ExtrapolatesToTheBoundary) {
  const MeshData mesh = unit_cube(10);
  const Quadratic f(4);
  const auto found = recover_hessians(mesh, values_of(mesh, f), HessianRecovery::double_projection);
  // The one-sided gradients of the boundary still reach the first layer inside, which is averaged outwards.
  EXPECT_LT(worst_difference(mesh, found, f.h, anywhere), 0.6);
}

TEST(HessianDoubleProjection, KeepsWhatItHasWhereNoVertexIsInside) {
  for (const MeshData& mesh : {support::regular_tet(), unit_cube(1)})
    for (const SymTensor& h :
         recover_hessians(mesh, values_of(mesh, Quadratic(1)), HessianRecovery::double_projection))
      EXPECT_TRUE(std::isfinite(trace(h)));
}

TEST(Hessian, DoesNotDependOnTheThreads) {
  MeshData mesh = unit_cube(14);
  support::jitter_interior(mesh, 0.01);
  const auto values = values_of(mesh, [](const Point& p) { return std::tanh(20 * (p.x + 0.3 * p.y - 0.5)); });
  for (const HessianRecovery recovery :
       {HessianRecovery::least_squares, HessianRecovery::double_projection}) {
    const auto expected = recover_hessians(mesh, values, recovery);
    for (const int threads : {1, 2, 3}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      EXPECT_EQ(recover_hessians(mesh, values, recovery), expected);
    }
  }
}

TEST(QuadraticFit, NeedsNinePointsInGeneralPosition) {
  QuadraticFit fit;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-1, 1);
  const Quadratic f(7);
  const auto add = [&](const Vec& d) { fit.add(d, f(d) - f({})); };
  for (int i = 0; i < 8; ++i) add({u(random), u(random), u(random)});
  EXPECT_FALSE(fit.hessian().has_value());
  for (int i = 0; i < 12; ++i) add({u(random), u(random), u(random)});
  ASSERT_TRUE(fit.hessian().has_value());
  EXPECT_LT(difference(*fit.hessian(), f.h), 1e-10);
  fit.clear();
  for (int i = 0; i < 40; ++i) add({u(random), u(random), 0});
  EXPECT_FALSE(fit.hessian().has_value());
  const SymTensor least = fit.least_norm_hessian();
  EXPECT_LT(difference({least.xx, least.xy, least.yy, 0, 0, 0}, {f.h.xx, f.h.xy, f.h.yy, 0, 0, 0}), 1e-9);
  EXPECT_EQ(least.zz, 0);
}

}  // namespace
}  // namespace weft::meshing::hessian_test
