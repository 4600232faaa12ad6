// Tiny named meshes for the tests, with all boundary triangles, and ways to disturb them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "meshing/mesh_data.h"
#include "meshing/point.h"
#include "meshing/structured_box.h"

namespace weft::support {

using meshing::MeshData;
using meshing::Point;

/// Gives every face of one tet, and every face between tets of different references, a triangle (reference 1
/// on the boundary, 2 inside). Slow and simple.
inline void add_boundary_triangles(MeshData& mesh) {
  struct Side {
    std::size_t tet;
    std::array<std::uint32_t, 3> triangle;
  };
  constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // normals pointing outwards
  std::map<std::array<std::uint32_t, 3>, std::vector<Side>> faces;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (const auto& f : kFaces) {
      const auto& v = mesh.tets[t];
      const std::array<std::uint32_t, 3> triangle{v[f[0]], v[f[1]], v[f[2]]};
      auto key = triangle;
      std::sort(key.begin(), key.end());
      faces[key].push_back({t, triangle});
    }
  for (const auto& [key, sides] : faces) {
    const bool boundary = sides.size() == 1;
    if (!boundary && mesh.tet_refs[sides[0].tet] == mesh.tet_refs[sides[1].tet]) continue;
    mesh.triangles.push_back(sides[0].triangle);
    mesh.triangle_refs.push_back(boundary ? 1 : 2);
  }
}

/// A mesh of these tets, each of reference 1, with its boundary triangles.
inline MeshData mesh_of(std::vector<Point> points, std::vector<std::array<std::uint32_t, 4>> tets) {
  MeshData mesh;
  mesh.points = std::move(points);
  mesh.point_refs.assign(mesh.points.size(), 0);
  mesh.tets = std::move(tets);
  mesh.tet_refs.assign(mesh.tets.size(), 1);
  add_boundary_triangles(mesh);
  return mesh;
}

/// A regular tet with edges of length `edge`.
inline MeshData regular_tet(double edge = 1) {
  const double a = edge;
  return mesh_of({{0, 0, 0},
                  {a, 0, 0},
                  {a / 2, a * std::sqrt(3.0) / 2, 0},
                  {a / 2, a / std::sqrt(12.0), a * std::sqrt(2.0 / 3.0)}},
                 {{0, 1, 2, 3}});
}

/// Two tets of volume 1/6 on the two sides of the face (0 1 2).
inline MeshData two_tets() {
  return mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}, {{0, 1, 2, 3}, {0, 2, 1, 4}});
}

/// The unit cube in n x n x n cells of 6 tets; triangle references 1 to 6 by side, edges and corners.
inline MeshData unit_cube(std::uint32_t n) {
  meshing::BoxOptions options;
  options.cells = {n, n, n};
  return meshing::structured_box(options);
}

/// The unit cube in n x n x n cells of 5 tets, every second cell mirrored; triangle reference 1.
inline MeshData unit_cube_of_fives(std::uint32_t n) {
  const auto vertex = [n](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return (k * (n + 1) + j) * (n + 1) + i;
  };
  std::vector<Point> points((n + 1) * (n + 1) * (n + 1));
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j)
      for (std::uint32_t k = 0; k <= n; ++k)
        points[vertex(i, j, k)] = {static_cast<double>(i) / n, static_cast<double>(j) / n,
                                   static_cast<double>(k) / n};
  // Corners of the cell by their bits: x 1, y 2, z 4. The middle tet joins the corners of even parity.
  constexpr std::array<std::array<std::uint32_t, 4>, 5> kCell = {
      {{0, 3, 5, 6}, {1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t cell = 0; cell < n * n * n; ++cell) {
    const std::uint32_t i = cell % n, j = cell / n % n, k = cell / n / n;
    const std::uint32_t mirror = (i + j + k) % 2;
    for (auto tet : kCell) {
      for (std::uint32_t& v : tet) {
        const std::uint32_t corner = v ^ mirror;
        v = vertex(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
      }
      const auto& [a, b, c, d] = tet;
      if (meshing::six_volume(points[a], points[b], points[c], points[d]) < 0) std::swap(tet[2], tet[3]);
      tets.push_back(tet);
    }
  }
  return mesh_of(std::move(points), std::move(tets));
}

/// Moves every vertex that no triangle touches by up to `amplitude` in each coordinate.
inline void jitter_interior(MeshData& mesh, double amplitude, unsigned seed = 1) {
  std::vector<bool> fixed(mesh.points.size(), false);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) fixed[v] = true;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-amplitude, amplitude);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (!fixed[v]) mesh.points[v] += Point{shift(random), shift(random), shift(random)};
}

/// Renames the vertices and reorders the tets at random: the same mesh without any order to rely on.
inline void shuffle(MeshData& mesh, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> old_to_new(mesh.points.size());
  for (std::uint32_t v = 0; v < old_to_new.size(); ++v) old_to_new[v] = v;
  std::shuffle(old_to_new.begin(), old_to_new.end(), random);
  const auto points = mesh.points;
  const auto refs = mesh.point_refs;
  for (std::size_t v = 0; v < points.size(); ++v) {
    mesh.points[old_to_new[v]] = points[v];
    mesh.point_refs[old_to_new[v]] = refs[v];
  }
  const auto rename = [&](auto& entities) {
    for (auto& entity : entities)
      for (std::uint32_t& v : entity) v = old_to_new[v];
  };
  rename(mesh.tets), rename(mesh.triangles), rename(mesh.edges);
  for (std::uint32_t& v : mesh.corners) v = old_to_new[v];
  for (std::uint32_t& v : mesh.required_points) v = old_to_new[v];
  std::vector<std::size_t> order(mesh.tets.size());
  for (std::size_t t = 0; t < order.size(); ++t) order[t] = t;
  std::shuffle(order.begin(), order.end(), random);
  const auto tets = mesh.tets;
  const auto tet_refs = mesh.tet_refs;
  for (std::size_t t = 0; t < order.size(); ++t) {
    mesh.tets[t] = tets[order[t]];
    mesh.tet_refs[t] = tet_refs[order[t]];
  }
}

}  // namespace weft::support
