// What of a mesh lies on which edge of a model, where the mesh or the model is inexact.
#include "meshing/geometry/model/model_classification.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshing/geometry/model/analytic_model.h"

namespace weft::meshing::model_classification_test {
namespace {

constexpr std::uint32_t kRing = 24;

/// A cylinder of radius 1 and height 2: vertex k of the lower ring is k, above it kRing + k; then the
/// centres.
MeshData cylinder() {
  MeshData m;
  for (const double z : {0.0, 2.0})
    for (std::uint32_t k = 0; k < kRing; ++k) {
      const double angle = 2 * std::numbers::pi * k / kRing;
      m.points.push_back({std::cos(angle), std::sin(angle), z});
    }
  m.points.push_back({0, 0, 0});
  m.points.push_back({0, 0, 2});
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::int32_t ref) {
    m.triangles.push_back({a, b, c});
    m.triangle_refs.push_back(ref);
  };
  for (std::uint32_t k = 0; k < kRing; ++k) {
    const std::uint32_t n = (k + 1) % kRing;
    add(k, n, kRing + n, 1);
    add(k, kRing + n, kRing + k, 1);
    add(n, k, 2 * kRing, 2);
    add(kRing + k, kRing + n, 2 * kRing + 1, 3);
  }
  m.point_refs.assign(m.points.size(), 0);
  return m;
}

void expect_rings_on_edges(const ModelClassification& c) {
  std::array<std::size_t, 2> found{};
  for (const ModelClassification::Edge& e : c.edges)
    if (e.vertices[1] < kRing || (e.vertices[0] >= kRing && e.vertices[1] < 2 * kRing))
      if (e.edge < 2) ++found[e.edge];
  EXPECT_EQ(found[0], kRing);
  EXPECT_EQ(found[1], kRing);
  for (std::uint32_t f = 0; f < c.face_group.size(); ++f) EXPECT_EQ(c.face_group[f], f);
}

TEST(ModelClassification, FindsTheEdgesBetweenFaces) {
  expect_rings_on_edges(
      classify_on_model(cylinder(), std::make_shared<const Model>(frustum_model({}, 1, 1, 2))));
}

TEST(ModelClassification, FindsTheEdgeOfVerticesThatAreExactlyOnOneFaceAndOffTheOther) {
  MeshData m = cylinder();
  for (std::uint32_t k = 0; k < kRing; k += 3) m.points[k].x *= 1 - 2e-5, m.points[k].y *= 1 - 2e-5;
  expect_rings_on_edges(classify_on_model(m, std::make_shared<const Model>(frustum_model({}, 1, 1, 2))));
}

/// The first edge of another model runs beside its faces, by as much as the tolerance of its node.
class LooseEdge : public GeometryModel {
 public:
  static constexpr double kGap = 8e-6;
  explicit LooseEdge(std::shared_ptr<const GeometryModel> model, double tolerance = 1e-5)
      : model_(std::move(model)) {
    nodes_.assign(model_->nodes().begin(), model_->nodes().end());
    edges_.assign(model_->edges().begin(), model_->edges().end());
    nodes_[0].tolerance = tolerance;
    edges_[0].form = {};
  }
  std::span<const ModelNode> nodes() const override { return nodes_; }
  std::span<const ModelEdge> edges() const override { return edges_; }
  std::span<const ModelFace> faces() const override { return model_->faces(); }
  CurveJet curve(std::uint32_t edge, double t) const override {
    CurveJet jet = model_->curve(edge, t);
    if (edge == 0) jet.x.x *= 1 - kGap, jet.x.y *= 1 - kGap;
    return jet;
  }
  SurfaceJet surface(std::uint32_t face, const Parameters& at) const override {
    return model_->surface(face, at);
  }
  Parameters on_face(std::uint32_t face, const EdgeUse& use, double t) const override {
    return model_->on_face(face, use, t);
  }
  const std::string& name() const override { return model_->name(); }
  const std::string& unit() const override { return model_->unit(); }
  std::span<const std::string> warnings() const override { return model_->warnings(); }

 private:
  std::shared_ptr<const GeometryModel> model_;
  std::vector<ModelNode> nodes_;
  std::vector<ModelEdge> edges_;
};

TEST(ModelClassification, FindsTheEdgeAtANodeFromWhichItsCurveIsOff) {
  const auto model = std::make_shared<LooseEdge>(frustum_model({}, 1, 1, 2));
  MeshData m = cylinder();
  // The node's vertex is on all faces there, as the node is; the others are on the curve.
  for (std::uint32_t k = 1; k < kRing; ++k)
    m.points[k].x *= 1 - LooseEdge::kGap, m.points[k].y *= 1 - LooseEdge::kGap;
  expect_rings_on_edges(classify_on_model(m, std::make_shared<const Model>(model)));
}

/// On either side of a node the same distance from it.
TEST(ModelClassification, GivesANodeTheLowestOfVerticesThatAreEquallyNear) {
  for (const double side : {1.0, -1.0}) {
    MeshData m = cylinder();
    const double half = std::numbers::pi / kRing, c = std::cos(half), s = std::sin(half);
    for (std::uint32_t v = 0; v < 2 * kRing; ++v) {
      const Point p = m.points[v];
      m.points[v] = {c * p.x - s * p.y, side * (s * p.x + c * p.y), p.z};
    }
    m.points[kRing - 1] = {m.points[0].x, -m.points[0].y, 0};
    const auto model = std::make_shared<LooseEdge>(frustum_model({}, 1, 1, 2), 0.1);
    const ModelClassification found = classify_on_model(m, std::make_shared<const Model>(model));
    EXPECT_EQ(found.nodes, (std::vector{std::pair{0u, 0u}}));
  }
}

/// The cylinder with triangles below each side, of the side's reference, whose vertices are all on the edge
/// between the side and the lower end: by place and normal they are the end's.
MeshData cylinder_with_caps(std::int32_t more) {
  MeshData m = cylinder();
  for (std::uint32_t k = 0; k + 2 < kRing; k += 2) {
    m.triangles.push_back({k, k + 1, k + 2});
    m.triangle_refs.push_back(1);
  }
  for (std::int32_t& ref : m.triangle_refs) ref += more;
  return m;
}

TEST(ModelClassification, BelievesReferencesThatAreIdsOfFacesWhereVerticesAllowSeveral) {
  const auto model = std::make_shared<const Model>(frustum_model({}, 1, 1, 2));
  const MeshData with_ids = cylinder_with_caps(0), others = cylinder_with_caps(10);
  const ModelClassification c = classify_on_model(with_ids, model), d = classify_on_model(others, model);
  std::size_t differ = 0;
  for (std::size_t i = 0; i < with_ids.triangles.size(); ++i) {
    EXPECT_EQ(c.triangle_face[i] + 1, static_cast<std::uint32_t>(with_ids.triangle_refs[i]));
    differ += c.triangle_face[i] != d.triangle_face[i];
  }
  EXPECT_EQ(differ, kRing / 2 - 1);  // other references tell nothing
}

/// The cylinder with all its records on the frustum's faces, and records of the nodes, exchanged or not.
MeshData with_records(bool exchanged) {
  MeshData m = cylinder();
  for (std::uint32_t v = 0; v < 2 * kRing; ++v) {
    const double angle = 2 * std::numbers::pi * (v % kRing) / kRing;
    m.association.edges.push_back({v, v < kRing ? 1 : 2, angle, 0});
  }
  m.association.nodes.push_back({0, exchanged ? 2 : 1});
  m.association.nodes.push_back({kRing, exchanged ? 1 : 2});
  return m;
}

TEST(ModelClassification, LeavesOutTheRecordsThatDoNotGiveBackTheirVertices) {
  // Another file of the same body counts its nodes otherwise: their vertices must not go to the other end.
  const auto model = std::make_shared<const Model>(frustum_model({}, 1, 1, 2));
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> nodes{{0, 0}, {kRing, 1}};
  const ModelClassification same = classify_on_model(with_records(false), model);
  EXPECT_EQ(same.nodes, nodes);
  EXPECT_TRUE(same.warnings.empty());
  const ModelClassification other = classify_on_model(with_records(true), model);
  EXPECT_EQ(other.nodes, nodes);
  ASSERT_EQ(other.warnings.size(), 1u);
  EXPECT_NE(other.warnings[0].find("2 of the mesh's 50 records"), std::string::npos) << other.warnings[0];
}

}  // namespace
}  // namespace weft::meshing::model_classification_test
