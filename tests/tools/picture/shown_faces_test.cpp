// Surfaces, cuts along tets and plane sections.
#include "tools/picture/shown_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "meshing/base/error.h"
#include "meshing/mesh/structured_box.h"

namespace weft::picture::shown_faces_test {
namespace {

using meshing::MeshData;
using meshing::Point;

MeshData box(std::uint32_t cells) {
  return meshing::structured_box({{cells, cells, cells}, {0, 0, 0}, {1, 1, 1}});
}

/// The box with its inner points moved a little, all tets still positive.
MeshData shaken_box(std::uint32_t cells, std::mt19937& random) {
  MeshData mesh = box(cells);
  std::uniform_real_distribution<double> jitter(-0.1 / cells, 0.1 / cells);
  for (Point& p : mesh.points)
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] > 0 && p[axis] < 1) p[axis] += jitter(random);
  return mesh;
}

MeshData without_triangles(MeshData mesh) {
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  mesh.required_triangles.clear();
  return mesh;
}

Plane random_plane(std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> inside(0.1, 0.9);
  const meshing::Vec n = {normal(random), normal(random), normal(random)};
  const meshing::Vec unit = (1 / norm(n)) * n;
  return {unit, dot(unit, {inside(random), inside(random), inside(random)})};
}

double area_of(const MeshData& mesh, const std::vector<ShownFace>& faces) {
  double area = 0;
  for (const ShownFace& face : faces) {
    const auto& [a, b, c] = face.vertices;
    area += norm(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a])) / 2;
  }
  return area;
}

std::multiset<std::array<std::uint32_t, 3>> vertex_sets(const std::vector<ShownFace>& faces) {
  std::multiset<std::array<std::uint32_t, 3>> sets;
  for (const ShownFace& face : faces) {
    auto vertices = face.vertices;
    std::ranges::sort(vertices);
    sets.insert(vertices);
  }
  return sets;
}

Point place_of(const MeshData& mesh, const Section::Corner& corner) {
  return mesh.points[corner.from] + corner.share * (mesh.points[corner.to] - mesh.points[corner.from]);
}

double area_of(const MeshData& mesh, const Section& section) {
  const auto corner = [&](int i) { return place_of(mesh, section.corners[static_cast<std::size_t>(i)]); };
  double area = 0;
  for (int i = 1; i + 1 < section.size; ++i)
    area += norm(cross(corner(i) - corner(0), corner(i + 1) - corner(0))) / 2;
  return area;
}

double section_area(const MeshData& mesh, const Plane& plane) {
  double area = 0;
  for (const Section& section : sections(mesh, plane)) area += area_of(mesh, section);
  return area;
}

TEST(ShownFaces, TheSurfaceIsTheSameWithAndWithoutTriangles) {
  const MeshData mesh = box(3), bare = without_triangles(mesh);
  EXPECT_NEAR(area_of(mesh, Surface(mesh).faces()), 6, 1e-12);
  EXPECT_EQ(vertex_sets(Surface(mesh).faces()), vertex_sets(Surface(bare).faces()));
  for (const ShownFace& face : Surface(mesh).faces()) EXPECT_TRUE(face.ref.has_value());
  for (const ShownFace& face : Surface(bare).faces()) EXPECT_FALSE(face.ref.has_value());
}

TEST(ShownFaces, OnlyTheReferencesAskedFor) {
  const MeshData mesh = box(3);
  const Surface surface(mesh, std::vector<std::int32_t>{2, 5});
  EXPECT_NEAR(area_of(mesh, surface.faces()), 2, 1e-12);
  for (const ShownFace& face : surface.faces()) EXPECT_TRUE(*face.ref == 2 || *face.ref == 5);
  EXPECT_TRUE(Surface(mesh, std::vector<std::int32_t>{9}).faces().empty());
}

TEST(ShownFaces, WhatACutLeavesIsTheClosedSurfaceOfTheTetsBehind) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 40; ++trial) {
    const MeshData mesh = without_triangles(shaken_box(4, random));
    const Plane plane = random_plane(random);
    double volume = 0;
    for (const auto& [a, b, c, d] : mesh.tets) {
      const auto& p = mesh.points;
      if (plane.distance(0.25 * (p[a] + p[b] + p[c] + p[d])) <= 0)
        volume += six_volume(p[a], p[b], p[c], p[d]) / 6;
    }
    double enclosed = 0;  // by the divergence theorem; faces of tets are ordered as seen from inside
    meshing::Vec closed;
    for (const ShownFace& face : Surface(mesh).behind(plane)) {
      const Point &a = mesh.points[face.vertices[0]], &b = mesh.points[face.vertices[1]],
                  &c = mesh.points[face.vertices[2]];
      enclosed -= dot(a, cross(b, c)) / 6;
      closed += cross(b - a, c - a);
    }
    EXPECT_NEAR(enclosed, volume, 1e-12);
    EXPECT_NEAR(norm(closed), 0, 1e-12);
  }
}

TEST(ShownFaces, TrianglesDoNotChangeACutAndFacesAreShownOnce) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 20; ++trial) {
    MeshData mesh = shaken_box(3, random);
    // Some triangles between tets, as between two materials.
    auto known = vertex_sets(Surface(mesh).faces());
    for (std::size_t t = 0; t < mesh.tets.size(); t += 3) {
      const auto& [a, b, c, d] = mesh.tets[t];
      const ShownFace face{{a, b, c}, meshing::kNoNeighbour, {}, false};
      const auto vertices = *vertex_sets({face}).begin();
      if (known.contains(vertices)) continue;
      known.insert(vertices);
      mesh.triangles.push_back(face.vertices);
      mesh.triangle_refs.push_back(77);
    }
    const Plane plane = random_plane(random);
    const auto shown = Surface(mesh).behind(plane);
    const auto sets = vertex_sets(shown);
    const MeshData bare = without_triangles(mesh);
    const auto expected = vertex_sets(Surface(bare).behind(plane));
    for (const auto& face : expected) EXPECT_EQ(sets.count(face), 1u);
    for (const ShownFace& face : shown) {
      const auto& tet = mesh.tets[face.tet];
      for (const std::uint32_t v : face.vertices) EXPECT_NE(std::ranges::find(tet, v), tet.end());
    }
  }
}

TEST(ShownFaces, ASurfaceAloneIsCutByTriangles) {
  MeshData mesh = box(4);
  mesh.tets.clear();
  mesh.tet_refs.clear();
  const Surface surface(mesh);
  EXPECT_NEAR(area_of(mesh, surface.faces()), 6, 1e-12);
  EXPECT_NEAR(area_of(mesh, surface.behind({{1, 0, 0}, 0.5})), 3, 1e-12);
}

TEST(ShownFaces, SectionsCoverThePlaneOnce) {
  const MeshData mesh = box(4);
  for (const double x : {0.0, 0.1, 0.25, 0.5, 0.6180339, 0.99}) {
    EXPECT_NEAR(section_area(mesh, {{1, 0, 0}, x}), 1, 1e-12) << x;
    EXPECT_NEAR(section_area(mesh, {{0, -1, 0}, -x}), x == 0 ? 0 : 1, 1e-12) << x;
  }
  EXPECT_EQ(section_area(mesh, {{0, 0, 1}, 1.5}), 0);
  EXPECT_NEAR(section_area(mesh, {{1 / std::sqrt(3), 1 / std::sqrt(3), 1 / std::sqrt(3)}, std::sqrt(3) / 2}),
              3 * std::sqrt(3) / 4, 1e-12);  // the regular hexagon
}

TEST(ShownFaces, ASectionDoesNotDependOnTheMesh) {
  std::mt19937 random(9);
  const MeshData coarse = box(2);
  for (int trial = 0; trial < 40; ++trial) {
    const Plane plane = random_plane(random);
    const MeshData fine = shaken_box(5, random);
    EXPECT_NEAR(section_area(coarse, plane), section_area(fine, plane), 1e-12);
    for (const Section& section : sections(fine, plane))
      for (int i = 0; i < section.size; ++i)
        EXPECT_NEAR(plane.distance(place_of(fine, section.corners[static_cast<std::size_t>(i)])), 0, 1e-12);
  }
}

TEST(ShownFaces, BrokenMeshesAreRefused) {
  MeshData bad_index = box(2);
  bad_index.tets[0][0] = 1000;
  EXPECT_THROW(Surface{bad_index}, meshing::InputError);
  MeshData thrice = box(2);
  for (int i = 0; i < 2; ++i) {
    thrice.tets.push_back(thrice.tets[0]);
    thrice.tet_refs.push_back(1);
  }
  EXPECT_THROW(Surface{thrice}, meshing::InputError);
}

}  // namespace
}  // namespace weft::picture::shown_faces_test
