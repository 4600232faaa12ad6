// Triangles on simple bodies, whose distances are known.
#include "meshing/geometry/model/face_deviations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "meshing/geometry/model/analytic_model.h"

namespace weft::meshing::face_deviations_test {
namespace {

/// Three points of the upright cylinder's side at height 1, 1 and 2, `angle` apart; records are as asked for.
MeshData on_side(const Model& side, double angle) {
  MeshData mesh;
  for (const auto& [share, z] : {std::pair{-0.5, 1.0}, {0.5, 1.0}, {0.0, 2.0}}) {
    const Point p{std::cos(share * angle), std::sin(share * angle), z};
    const OnFace on = side.closest_on_face(0, p);
    mesh.association.faces.push_back(
        {static_cast<std::uint32_t>(mesh.points.size()), 1, on.at[0], on.at[1], 0});
    mesh.points.push_back(p);
  }
  return mesh;
}

TEST(FaceDeviations, AreThoseOfCentroids) {
  for (const auto& geometry : {frustum_model({}, 1, 1, 3), without_formulas(frustum_model({}, 1, 1, 3))}) {
    const Model model(geometry);
    const MeshData mesh = on_side(model, 0.4);
    const double centroid = (2 * std::cos(0.2) + 1) / 3;
    EXPECT_NEAR(FaceDeviations(mesh, model).at({0, 1, 2}), 1 - centroid, 1e-12);
  }
}

TEST(FaceDeviations, AreNoneWithoutAFaceInCommon) {
  const Model model(frustum_model({}, 1, 1, 3));
  MeshData mesh = on_side(model, 0.4);
  mesh.association.faces[1].id = 2;
  EXPECT_TRUE(std::isnan(FaceDeviations(mesh, model).at({0, 1, 2})));
  mesh.association.faces.pop_back();
  EXPECT_TRUE(std::isnan(FaceDeviations(mesh, model).at({0, 1, 2})));
  for (auto& record : mesh.association.faces) record.id = 99;  // which the model has not
  EXPECT_TRUE(std::isnan(FaceDeviations(mesh, model).at({0, 1, 0})));
}

/// Of a triangle beside an edge, whose vertices have records of the faces on both sides.
TEST(FaceDeviations, AreTheLeastOverFacesInCommon) {
  const Model model(frustum_model({}, 1, 1, 3));
  MeshData mesh;
  for (const double angle : {0.0, 0.3, 0.6}) {
    const Point p{std::cos(angle), std::sin(angle), 0};
    const auto v = static_cast<std::uint32_t>(mesh.points.size());
    for (const std::int32_t face : {1, 2}) {
      const OnFace on = model.closest_on_face(static_cast<std::uint32_t>(face - 1), p);
      mesh.association.faces.push_back({v, face, on.at[0], on.at[1], 0});
    }
    mesh.points.push_back(p);
  }
  EXPECT_NEAR(FaceDeviations(mesh, model).at({0, 1, 2}), 0, 1e-12);  // in the plane of the lower end
}

}  // namespace
}  // namespace weft::meshing::face_deviations_test
