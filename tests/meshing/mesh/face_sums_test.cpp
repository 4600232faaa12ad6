// The sums say of every damage to tets and triangles what the full check says.
#include "meshing/mesh/face_sums.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <random>

#include "meshing/mesh/check_mesh.h"
#include "tests/support/meshes.h"

namespace weft::meshing::face_sums_test {
namespace {

/// A jittered cube of two materials, with triangles between them, numbered at random.
MeshData sound_mesh(unsigned seed) {
  MeshData mesh = seed % 2 == 0 ? support::unit_cube(3) : support::unit_cube_of_fives(3);
  support::jitter_interior(mesh, 0.03, seed);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double x = 0;
    for (const std::uint32_t v : mesh.tets[t]) x += mesh.points[v].x / 4;
    mesh.tet_refs[t] = x < 0.4 ? -7 : 9;
  }
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  support::add_boundary_triangles(mesh);
  support::shuffle(mesh, seed);
  return mesh;
}

using Damage = std::function<void(MeshData&, std::mt19937&)>;

std::uint32_t any(std::size_t count, std::mt19937& random) {
  return static_cast<std::uint32_t>(random() % count);
}

std::vector<Damage> damages() {
  return {
      [](MeshData& m, std::mt19937& r) {  // a tet is gone
        const std::uint32_t t = any(m.tets.size(), r);
        m.tets.erase(m.tets.begin() + t);
        m.tet_refs.erase(m.tet_refs.begin() + t);
      },
      [](MeshData& m, std::mt19937& r) {  // a tet twice
        const std::uint32_t t = any(m.tets.size(), r);
        m.tets.push_back(m.tets[t]);
        m.tet_refs.push_back(m.tet_refs[t]);
      },
      [](MeshData& m, std::mt19937& r) {  // a tet with its vertices in a wrong order
        auto& tet = m.tets[any(m.tets.size(), r)];
        std::swap(tet[any(2, r)], tet[2 + any(2, r)]);
      },
      [](MeshData& m, std::mt19937& r) {
        m.tets[any(m.tets.size(), r)][any(4, r)] = any(m.points.size(), r);
      },
      [](MeshData& m, std::mt19937& r) { m.tets[any(m.tets.size(), r)][any(4, r)] = 1u << 31; },
      [](MeshData& m, std::mt19937& r) { m.tet_refs[any(m.tets.size(), r)] = 5; },
      [](MeshData& m, std::mt19937& r) {  // another material's tet
        std::int32_t& ref = m.tet_refs[any(m.tets.size(), r)];
        ref = ref == 9 ? -7 : 9;
      },
      [](MeshData& m, std::mt19937& r) {  // a triangle is gone
        const std::uint32_t t = any(m.triangles.size(), r);
        m.triangles.erase(m.triangles.begin() + t);
        m.triangle_refs.erase(m.triangle_refs.begin() + t);
      },
      [](MeshData& m, std::mt19937& r) {  // a triangle twice
        auto [a, b, c] = m.triangles[any(m.triangles.size(), r)];
        m.triangles.push_back({b, a, c});
        m.triangle_refs.push_back(1);
      },
      [](MeshData& m, std::mt19937& r) {  // a triangle inside, which may be
        const auto& tet = m.tets[any(m.tets.size(), r)];
        m.triangles.push_back({tet[2], tet[0], tet[1]});
        m.triangle_refs.push_back(77);
      },
      [](MeshData& m, std::mt19937& r) {
        m.triangles[any(m.triangles.size(), r)][any(3, r)] = any(m.points.size(), r);
      },
      [](MeshData& m, std::mt19937& r) { m.triangles[any(m.triangles.size(), r)][any(3, r)] = 1u << 31; },
      [](MeshData& m, std::mt19937& r) {
        m.points[any(m.points.size(), r)].y = std::numeric_limits<double>::quiet_NaN();
      },
      [](MeshData& m, std::mt19937& r) {  // a vertex goes far
        m.points[any(m.points.size(), r)].z += 0.5;
      },
      [](MeshData& m, std::mt19937& r) {  // two vertices have become one
        const std::uint32_t from = any(m.points.size(), r), to = any(m.points.size(), r);
        for (auto& tet : m.tets)
          for (std::uint32_t& v : tet) v = v == from ? to : v;
      },
  };
}

TEST(FaceSums, VanishForSoundMeshes) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const MeshData mesh = sound_mesh(seed);
    ASSERT_TRUE(check_mesh(mesh).ok());
    const FaceSums sums = sum_faces(mesh);
    EXPECT_EQ(sums.faults, 0u);
    EXPECT_EQ(sums.faces, 0u);
    EXPECT_EQ(sums.references, 0u);
  }
  EXPECT_TRUE(sum_faces({}).ok());
}

TEST(FaceSums, JudgeDamagedMeshesAsTheFullCheckDoes) {
  int sound = 0, damaged = 0;
  for (unsigned seed = 1; seed <= 40; ++seed)
    for (const Damage& damage : damages()) {
      std::mt19937 random(seed);
      MeshData mesh = sound_mesh(seed);
      damage(mesh, random);
      const CheckReport report = check_mesh(mesh);
      EXPECT_EQ(sum_faces(mesh).ok(), report.ok()) << (report.ok() ? "sound" : report.problems[0]);
      ++(report.ok() ? sound : damaged);
    }
  EXPECT_GT(sound, 20);
  EXPECT_GT(damaged, 400);
}

/// Two solids that touch, one of which has lost its tets to the other's reference: faces cancel, references
/// do not.
TEST(FaceSums, SeeMaterialsWithoutTrianglesBetween) {
  MeshData mesh = support::two_tets();
  mesh.tet_refs = {1, 2};
  const FaceSums sums = sum_faces(mesh);
  EXPECT_EQ(sums.faults, 0u);
  EXPECT_EQ(sums.faces, 0u);
  EXPECT_NE(sums.references, 0u);
}

/// Vertices are known by their ids alone.
TEST(CrowdedSides, AreSeenWhereSumsCancel) {
  MeshData mesh = support::mesh_of(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0.1, 0.1, 2}, {0.1, 0.1, -2}},
      {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}, {0, 2, 1, 6}});
  std::erase_if(mesh.triangles, [](const auto& t) { return *std::ranges::max_element(t) < 3; });
  mesh.triangle_refs.resize(mesh.triangles.size());
  EXPECT_TRUE(sum_faces(mesh).ok());
  EXPECT_FALSE(check_mesh(mesh).ok());
  EXPECT_EQ(crowded_sides(mesh), 2u);
}

TEST(CrowdedSides, AreNoneOfSoundMeshes) {
  for (MeshData mesh :
       {support::unit_cube(4), support::ball(2, 3), support::cylinder(12, 2, 3, 1), MeshData{}}) {
    support::shuffle(mesh, 7);
    EXPECT_EQ(crowded_sides(mesh), 0u);
    if (!mesh.tets.empty()) mesh.tets.push_back(mesh.tets[mesh.tets.size() / 2]);
    EXPECT_EQ(crowded_sides(mesh), mesh.tets.empty() ? 0u : 4u);
  }
}

TEST(FaceSums, OfPartsAddUp) {
  const MeshData mesh = support::unit_cube(3);
  FaceSums sums;
  for (const std::size_t part : {0u, 1u, 2u}) {
    MeshData some = mesh;
    some.tets.clear();
    some.triangles.clear();
    for (std::size_t t = part; t < mesh.tets.size(); t += 3) some.tets.push_back(mesh.tets[t]);
    some.tet_refs.assign(some.tets.size(), 1);
    for (const auto& triangle : mesh.triangles)
      for (const auto& tet : some.tets)
        if (std::ranges::all_of(triangle,
                                [&](std::uint32_t v) { return std::ranges::find(tet, v) != tet.end(); }))
          some.triangles.push_back(triangle);
    some.triangle_refs.assign(some.triangles.size(), 1);
    std::vector<std::uint64_t> ids(mesh.points.size());
    for (std::size_t v = 0; v < ids.size(); ++v) ids[v] = 1000000007 * (v + 1);
    const FaceSums of_part = sum_faces(some, ids);
    EXPECT_EQ(of_part.faults, 0u);
    EXPECT_NE(of_part.faces, 0u);
    sums += of_part;
  }
  EXPECT_TRUE(sums.ok());
}

}  // namespace
}  // namespace weft::meshing::face_sums_test
