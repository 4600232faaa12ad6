// Adaptation of meshes whose boundary lies on a model: balls and frustums, with formulas and without.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "meshing/adapt/adapt.h"
#include "meshing/base/error.h"
#include "meshing/geometry/model/analytic_model.h"
#include "meshing/initial/closed_surface.h"
#include "meshing/initial/fill_volume.h"
#include "meshing/initial/initial_grid.h"
#include "meshing/initial/shapes.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/metric/sources/curvature_metric.h"

namespace weft::meshing::adapt_on_model_test {
namespace {

constexpr double kPi = std::numbers::pi;

MeshData filled(const MeshData& surface) {
  FillOptions options;
  return fill_volume(make_initial_grid(close_surface(surface, {1e-9}), {}).mesh, options).mesh;
}

const MeshData& coarse_ball() {
  static const MeshData mesh = filled(ball_surface({{}, 1, 0.8}));
  return mesh;
}
const MeshData& coarse_cylinder() {
  static const MeshData mesh = filled(cylinder_surface({{}, 1, 2, 0.7}));
  return mesh;
}

std::shared_ptr<const Model> ball() { return std::make_shared<const Model>(ball_model({}, 1)); }
std::shared_ptr<const Model> cylinder() { return std::make_shared<const Model>(frustum_model({}, 1, 1, 2)); }
std::shared_ptr<const Model> unknown_cylinder() {
  return std::make_shared<const Model>(without_formulas(frustum_model({}, 1, 1, 2)));
}

AdaptResult adapted(const MeshData& mesh, std::shared_ptr<const Model> model, double size, int threads = 1) {
  const LogMetricField metric(mesh.points.size(), LogMetric(identity_tensor(-2 * std::log(size))));
  AdaptOptions options;
  options.model = std::move(model);
  options.threads = threads;
  return adapt(mesh, {&mesh, &metric}, options);
}

void expect_good(const AdaptResult& result) {
  EXPECT_TRUE(check_mesh(result.mesh, 5).ok());
  ASSERT_TRUE(result.report.model);
  const ModelAccount& account = *result.report.model;
  EXPECT_EQ(account.off, 0u);
  EXPECT_LE(account.largest, 1e-12 * account.size);
  EXPECT_GT(account.least_normal, 0);
  EXPECT_EQ(account.unclassified_triangles, 0u);
}

TEST(AdaptOnModel, KeepsEveryVertexOfABallOnTheSphere) {
  const AdaptResult result = adapted(coarse_ball(), ball(), 0.25);
  expect_good(result);
  for (const auto& t : result.mesh.triangles)
    for (const std::uint32_t v : t) EXPECT_NEAR(norm(result.mesh.points[v]), 1, 1e-14);
  // The volume errs by the sagitta of the triangles.
  EXPECT_NEAR(check_mesh(result.mesh, 1).volume, 4 * kPi / 3, 0.1);
}

TEST(AdaptOnModel, KeepsACylindersSideAndItsEndsApart) {
  for (const auto& model : {cylinder(), unknown_cylinder()}) {
    const AdaptResult result = adapted(coarse_cylinder(), model, 0.25);
    expect_good(result);
    const Model& m = *model;
    for (const auto& r : result.mesh.association.faces) {
      const OnFace q = m.point_on_face(static_cast<std::uint32_t>(r.id - 1), {r.u, r.v});
      EXPECT_NEAR(norm(q.x - result.mesh.points[r.vertex]), 0, 1e-12);
    }
    for (const auto& r : result.mesh.association.edges)
      EXPECT_NEAR(norm(m.curve(static_cast<std::uint32_t>(r.id - 1), r.t).x - result.mesh.points[r.vertex]),
                  0, 1e-12);
    EXPECT_GT(result.mesh.association.edges.size(), 40u);
  }
}

TEST(AdaptOnModel, WithTwoThreadsIsAsGood) { expect_good(adapted(coarse_ball(), ball(), 0.2, 2)); }

TEST(AdaptOnModel, BringsAMeshThatIsOffItOntoIt) {
  MeshData mesh = coarse_ball();
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (norm(mesh.points[i]) > 0.99)
      mesh.points[i] = (1 + 0.004 * std::sin(7.0 * static_cast<double>(i))) * mesh.points[i];
  expect_good(adapted(mesh, ball(), 0.3));
}

/// The node of a closed edge is a corner; snapping takes it to the model.
TEST(AdaptOnModel, LeavesCornersOfRequiredTrianglesWhereTheyAre) {
  const auto model = cylinder();
  for (const bool required : {false, true}) {
    MeshData mesh = coarse_cylinder();
    const Point node = model->node(0);
    const auto corner = static_cast<std::uint32_t>(
        std::ranges::min_element(mesh.points, {}, [&](const Point& p) { return norm2(p - node); }) -
        mesh.points.begin());
    ASSERT_LT(norm(mesh.points[corner] - node), 1e-12);
    mesh.points[corner].z += 1e-6;
    for (std::uint32_t t = 0; required && t < mesh.triangles.size(); ++t)
      if (std::ranges::count(mesh.triangles[t], corner) > 0) mesh.required_triangles.push_back(t);
    const AdaptResult result = adapted(mesh, model, 0.4);
    EXPECT_EQ(std::ranges::count(result.mesh.points, mesh.points[corner]), required ? 1 : 0);
  }
}

TEST(AdaptOnModel, IsRefusedWhereTheModelIsAnotherBodys) {
  const auto far = std::make_shared<const Model>(ball_model({5, 0, 0}, 1));
  EXPECT_THROW(adapted(coarse_ball(), far, 0.3), InputError);
  const auto large = std::make_shared<const Model>(ball_model({}, 1000));
  try {
    adapted(coarse_ball(), large, 0.3);
    FAIL() << "a model a thousand times as large was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--geometry-scale 0.001"));
  }
  EXPECT_NO_THROW(adapted(coarse_ball(), std::make_shared<const Model>(ball_model({}, 1000), 0.001), 0.3));
}

TEST(AdaptOnModel, IsRefusedWhereOnlyPartOfAnotherBodyHappensToLieOnIt) {
  // The lower end is the cylinder's, nothing else is.
  const auto narrow = std::make_shared<const Model>(frustum_model({}, 1, 0.8, 2));
  EXPECT_THROW(adapted(coarse_cylinder(), narrow, 0.4), InputError);
  const auto beside = std::make_shared<const Model>(frustum_model({0.5, 0, 0}, 1, 1, 2));
  EXPECT_THROW(adapted(coarse_cylinder(), beside, 0.4), InputError);
}

TEST(AdaptOnModel, IsRefusedWhereTheMeshIsAFewHundredthsTooLarge) {
  MeshData mesh = coarse_cylinder();
  for (Point& p : mesh.points) p = 1.02 * p;
  try {
    adapted(mesh, cylinder(), 0.4);
    FAIL() << "a mesh 2 % too large was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("1.02 times as large"));
  }
}

/// A cylinder's ends without its side.
class Ends : public GeometryModel {
 public:
  std::span<const ModelNode> nodes() const override { return whole_->nodes(); }
  std::span<const ModelEdge> edges() const override { return whole_->edges(); }
  std::span<const ModelFace> faces() const override { return whole_->faces().subspan(1); }
  CurveJet curve(std::uint32_t edge, double t) const override { return whole_->curve(edge, t); }
  SurfaceJet surface(std::uint32_t face, const Parameters& at) const override {
    return whole_->surface(face + 1, at);
  }
  Parameters on_face(std::uint32_t face, const EdgeUse& use, double t) const override {
    return whole_->on_face(face + 1, use, t);
  }
  const std::string& name() const override { return whole_->name(); }
  const std::string& unit() const override { return whole_->unit(); }
  std::span<const std::string> warnings() const override { return {}; }

 private:
  std::shared_ptr<const GeometryModel> whole_ = frustum_model({}, 1, 1, 2);
};

TEST(AdaptOnModel, ReconstructsWhatLiesOnNoFaceAndSaysSo) {
  const AdaptResult result =
      adapted(coarse_cylinder(), std::make_shared<const Model>(std::make_shared<Ends>()), 0.4);
  EXPECT_GT(result.report.model->unclassified_triangles, 0u);
  EXPECT_THAT(result.report.warnings, testing::Contains(testing::HasSubstr("lie on no face of the model")));
}

TEST(AdaptOnModel, KeepsTheShapeOfABallThatIsSmallInItsDomain) {
  // The default of hausd, 0.1 % of the diagonal, is more than the ball's radius.
  const double radius = 0.01;
  MeshData surface = ball_surface({{}, 10, 8});
  const MeshData inner = ball_surface({{}, radius, 0.3 * radius});
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  surface.points.insert(surface.points.end(), inner.points.begin(), inner.points.end());
  for (const auto& t : inner.triangles)
    surface.triangles.push_back({t[0] + first, t[2] + first, t[1] + first});
  surface.point_refs.resize(surface.points.size());
  surface.triangle_refs.resize(surface.triangles.size());
  const MeshData mesh = filled(surface);
  const auto model = std::make_shared<const Model>(ball_model({}, radius));
  const AdaptResult result = adapted(mesh, model, 5);
  EXPECT_EQ(result.report.model->off, 0u);
  EXPECT_GT(result.report.model->least_normal, 0.9);
  EXPECT_LT(result.report.model->deviation, 2.5 * model->detail(0));
}

TEST(AdaptOnModel, CurvatureOfACoarseMeshIsTheModels) {
  CurvatureOptions options;
  options.per_turn = 20;
  const LogMetricField field = curvature_metric(coarse_ball(), options, ball());
  for (std::size_t v = 0; v < field.size(); ++v)
    if (norm(coarse_ball().points[v]) > 0.99) {
      EXPECT_NEAR(field[v].xx, -2 * std::log(2 * kPi / 20), 1e-9);
    }
}

}  // namespace
}  // namespace weft::meshing::adapt_on_model_test
