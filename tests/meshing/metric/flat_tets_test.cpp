// Tets that are exactly positive and flat in doubles: what adapt and verify accept, everything accepts.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "meshing/fields/transfer.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/mesh/predicates.h"
#include "meshing/metric/background.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/sources/implied_metric.h"
#include "tests/support/meshes.h"

namespace weft::meshing::flat_tets_test {
namespace {

/// A tet of four points that are coplanar up to rounding: positive, but of a volume that computes to nothing
/// or less.
MeshData flat_tet(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (;;) {
    std::vector<Point> p;
    for (int i = 0; i < 4; ++i) {
      const double x = uniform(random), y = uniform(random);
      p.push_back({x, y, 0.3 * x + 0.7 * y});
    }
    if (orientation(p[0], p[1], p[2], p[3]) > 0 && six_volume(p[0], p[1], p[2], p[3]) <= 0)
      return support::mesh_of(std::move(p), {{0, 1, 2, 3}});
  }
}

/// The same with a good tet on the side of its face 0.
MeshData flat_tet_and_another(unsigned seed) {
  MeshData mesh = flat_tet(seed);
  auto points = mesh.points;
  const auto& t = mesh.tets[0];
  const Vec normal = cross(points[t[2]] - points[t[1]], points[t[3]] - points[t[1]]);
  // The tet's own vertex 0 lies on the other side of that face.
  const double side = orientation(points[t[1]], points[t[2]], points[t[3]], points[t[0]]) > 0 ? -1 : 1;
  points.push_back(midpoint(points[t[1]], points[t[2]]) + side * normal);
  std::array<std::uint32_t, 4> other = {t[1], t[2], t[3], 4};
  if (orientation(points[other[0]], points[other[1]], points[other[2]], points[other[3]]) < 0)
    std::swap(other[0], other[1]);
  return support::mesh_of(std::move(points), {t, other});
}

/// With volumes of exactly 0 among them.
std::vector<MeshData> flat_meshes() {
  std::vector<MeshData> meshes;
  for (unsigned seed = 1; seed <= 20; ++seed)
    meshes.push_back(flat_tet(seed)), meshes.push_back(flat_tet_and_another(seed));
  return meshes;
}

bool is_finite(const SymTensor& t) { return std::isfinite(t.xx + t.xy + t.yy + t.xz + t.yz + t.zz); }

TEST(FlatTets, AreAccepted) {
  for (const MeshData& mesh : flat_meshes()) {
    ASSERT_TRUE(check_mesh(mesh).ok());
    const LogMetricField constant(mesh.points.size(), identity_tensor(3));
    EXPECT_GE(complexity(mesh, constant), 0);
    for (const LogMetric& l : implied_metric(mesh)) EXPECT_TRUE(is_finite(l));
    SolutionData fields{mesh.points.size(),
                        {{Field::Kind::scalar, std::vector<double>(mesh.points.size(), 5), "u"}}};
    for (const TransferMethod method : {TransferMethod::linear, TransferMethod::conservative}) {
      const Transfer result = transfer(mesh, fields, mesh, method);
      for (const double value : result.fields.fields[0].values) EXPECT_NEAR(value, 5, 1e-6);
    }
  }
}

TEST(FlatTets, HaveAMetricAllAround) {
  for (const MeshData& mesh : flat_meshes()) {
    LogMetricField field;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
      field.push_back(identity_tensor(static_cast<double>(v)));
    const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-2, 2);
    for (int i = 0; i < 100; ++i)
      for (std::uint32_t hint = 0; hint < mesh.tets.size(); ++hint) {
        const auto sample = background.at({uniform(random), uniform(random), uniform(random)}, hint);
        EXPECT_GE(sample.log_metric.xx, -1e-9);
        EXPECT_LE(sample.log_metric.xx, static_cast<double>(mesh.points.size()) - 1 + 1e-9);
      }
  }
}

}  // namespace
}  // namespace weft::meshing::flat_tets_test
