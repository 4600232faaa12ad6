// Tests of face neighbours, triangle matching and unique edges against slow and simple counterparts.
#include "meshing/mesh/adjacency.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "meshing/base/error.h"
#include "tests/support/meshes.h"

namespace weft::meshing::adjacency_test {
namespace {

using support::two_tets;
using support::unit_cube;
using support::unit_cube_of_fives;
using Face = std::array<std::uint32_t, 3>;

Face face_of(const MeshData& mesh, std::uint32_t code) {
  const auto& v = mesh.tets[code / 4];
  Face face;
  for (std::uint32_t i = 0, n = 0; i < 4; ++i)
    if (i != code % 4) face[n++] = v[i];
  std::sort(face.begin(), face.end());
  return face;
}

/// Neighbours by a map of all faces.
std::vector<std::array<std::uint32_t, 4>> slow_neighbours(const MeshData& mesh) {
  std::map<Face, std::vector<std::uint32_t>> codes;
  for (std::uint32_t code = 0; code < 4 * mesh.tets.size(); ++code)
    codes[face_of(mesh, code)].push_back(code);
  std::vector<std::array<std::uint32_t, 4>> neighbours(mesh.tets.size());
  for (const auto& [face, sides] : codes) {
    neighbours[sides.front() / 4][sides.front() % 4] = sides.size() == 2 ? sides.back() : kNoNeighbour;
    if (sides.size() == 2) neighbours[sides.back() / 4][sides.back() % 4] = sides.front();
  }
  return neighbours;
}

std::vector<MeshData> sample_meshes() {
  std::vector<MeshData> meshes = {support::regular_tet(), two_tets(), unit_cube(1), unit_cube(5),
                                  unit_cube_of_fives(4)};
  meshes.push_back(unit_cube(6));
  support::shuffle(meshes.back());
  meshes.push_back(unit_cube(12));  // several runs of tets, with many faces between them and few
  meshes.push_back(unit_cube(12));
  support::shuffle(meshes.back());
  return meshes;
}

std::string error_of(const std::vector<std::array<std::uint32_t, 4>>& tets, std::size_t num_vertices) {
  try {
    build_adjacency(tets, num_vertices);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Adjacency, PairsTheCommonFaceOfTwoTets) {
  const MeshData mesh = two_tets();
  const Adjacency adjacency = build_adjacency(mesh.tets, mesh.points.size());
  const std::uint32_t none = kNoNeighbour;
  EXPECT_EQ(adjacency.neighbours[0], (std::array<std::uint32_t, 4>{none, none, none, 4 + 3}));
  EXPECT_EQ(adjacency.neighbours[1], (std::array<std::uint32_t, 4>{none, none, none, 0 + 3}));
}

TEST(Adjacency, EqualsTheSlowAnswer) {
  for (const MeshData& mesh : sample_meshes())
    EXPECT_EQ(build_adjacency(mesh.tets, mesh.points.size()).neighbours, slow_neighbours(mesh));
}

TEST(Adjacency, IsTheSameForAnyNumberOfThreads) {
  MeshData mesh = unit_cube(16);
  support::shuffle(mesh);
  const auto expected = build_adjacency(mesh.tets, mesh.points.size()).neighbours;
  const auto edges = unique_edges(mesh.tets, mesh.points.size());
  for (const int threads : {1, 2, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(build_adjacency(mesh.tets, mesh.points.size()).neighbours, expected);
    EXPECT_EQ(unique_edges(mesh.tets, mesh.points.size()).others, edges.others);
  }
}

TEST(Adjacency, AcceptsNoTetsAtAll) {
  EXPECT_TRUE(build_adjacency({}, 0).neighbours.empty());
  EXPECT_TRUE(unique_edges({}, 3).others.empty());
}

TEST(Adjacency, RefusesAFaceOfThreeTets) {
  EXPECT_EQ(error_of({{4, 5, 6, 7}, {0, 1, 2, 3}, {0, 2, 1, 4}, {1, 2, 0, 5}}, 8),
            "tets 2, 3 and 4: share the face (1 2 3)");
}

TEST(Adjacency, NamesTheSameOverusedFaceEveryTime) {
  MeshData mesh = unit_cube(8);
  const std::uint32_t extra = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.push_back({2, 2, 2});
  for (std::size_t t = 0; t < 500; ++t)
    mesh.tets.push_back({mesh.tets[t][0], mesh.tets[t][1], mesh.tets[t][2], extra});
  const std::string error = error_of(mesh.tets, mesh.points.size());
  EXPECT_NE(error.find("share the face"), std::string::npos) << error;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(error_of(mesh.tets, mesh.points.size()), error);
}

TEST(Adjacency, RefusesAFaceOfThreeTetsThatAreFarApartInTheOrder) {
  const MeshData mesh = unit_cube(16);
  for (const std::size_t first : {std::size_t{0}, mesh.tets.size() / 2, mesh.tets.size() - 3}) {
    auto tets = mesh.tets;
    tets.push_back(tets[first]);
    EXPECT_NE(error_of(tets, mesh.points.size()).find("share the face"), std::string::npos) << first;
    // Two that share a face among themselves, and with two others.
    const auto neighbours = build_adjacency(mesh.tets, mesh.points.size()).neighbours[first];
    const std::uint32_t next =
        *std::ranges::find_if(neighbours, [](std::uint32_t n) { return n != kNoNeighbour; });
    tets.push_back(tets[next / 4]);
    EXPECT_NE(error_of(tets, mesh.points.size()).find("share the face"), std::string::npos) << first;
  }
}

TEST(Adjacency, TellsWhetherTetsLieOnDifferentSidesOfTheirFaces) {
  for (const MeshData& mesh : sample_meshes()) {
    EXPECT_TRUE(build_adjacency(mesh.tets, mesh.points.size()).turns_differ);
    if (mesh.tets.size() < 2) continue;
    for (const std::size_t t : {std::size_t{0}, mesh.tets.size() / 2, mesh.tets.size() - 1}) {
      auto tets = mesh.tets;
      std::swap(tets[t][1], tets[t][3]);
      EXPECT_FALSE(build_adjacency(tets, mesh.points.size()).turns_differ) << t;
    }
  }
}

TEST(Adjacency, RefusesVerticesOutOfRange) {
  EXPECT_EQ(error_of({{0, 1, 2, 3}, {0, 1, 2, 4}}, 4), "tet 2: vertex out of range");
  const std::vector<Face> triangles = {{0, 1, 9}};
  const std::vector<std::array<std::uint32_t, 4>> tets = {{0, 1, 2, 3}};
  EXPECT_THROW(match_triangles(triangles, tets, 4), InputError);
}

TEST(MatchTriangles, FindsTheFaceOfEveryTriangle) {
  for (const MeshData& mesh : sample_meshes()) {
    const auto neighbours = slow_neighbours(mesh);
    const auto codes = match_triangles(mesh.triangles, mesh.tets, mesh.points.size());
    ASSERT_EQ(codes.size(), mesh.triangles.size());
    for (std::size_t i = 0; i < codes.size(); ++i) {
      ASSERT_NE(codes[i], kNoNeighbour);
      Face triangle = mesh.triangles[i];
      std::sort(triangle.begin(), triangle.end());
      EXPECT_EQ(face_of(mesh, codes[i]), triangle);
      EXPECT_EQ(neighbours[codes[i] / 4][codes[i] % 4], kNoNeighbour);
    }
  }
}

TEST(MatchTriangles, TakesTheSmallerCodeOfAnInteriorFaceAndNoneForAStranger) {
  const MeshData mesh = two_tets();
  const std::vector<Face> triangles = {{2, 0, 1}, {0, 3, 4}, {1, 2, 0}, {4, 2, 0}};
  const auto codes = match_triangles(triangles, mesh.tets, mesh.points.size());
  EXPECT_EQ(codes, (std::vector<std::uint32_t>{3, kNoNeighbour, 3, 4 + 2}));
}

TEST(UniqueEdges, EqualsTheSlowAnswer) {
  for (const MeshData& mesh : sample_meshes()) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> expected, found;
    for (const auto& tet : mesh.tets)
      for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j) expected.insert(std::minmax(tet[i], tet[j]));
    const EdgeLists edges = unique_edges(mesh.tets, mesh.points.size());
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
      EXPECT_TRUE(std::is_sorted(edges.of(v).begin(), edges.of(v).end()));
      for (const std::uint32_t w : edges.of(v)) found.insert({v, w});
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(edges.others.size(), expected.size());
  }
}

}  // namespace
}  // namespace weft::meshing::adjacency_test
