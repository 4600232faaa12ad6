// Tiny named meshes for the tests, with all boundary triangles, and ways to disturb them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/structured_box.h"

namespace weft::support {

using meshing::MeshData;
using meshing::Point;
using meshing::Triangle;

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

/// Keeps the tets for which `keep` says so, and the points that they need; the boundary is made anew.
template <class Keep>
MeshData part_of(const MeshData& mesh, Keep keep) {
  std::vector<Point> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::map<std::uint32_t, std::uint32_t> old_to_new;
  for (auto tet : mesh.tets) {
    if (!keep(tet)) continue;
    for (std::uint32_t& v : tet) {
      const auto [at, is_new] = old_to_new.try_emplace(v, static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back(mesh.points[v]);
      v = at->second;
    }
    tets.push_back(tet);
  }
  return mesh_of(std::move(points), std::move(tets));
}

/// Cells of a grid, like those of a chessboard and some more: bodies that touch themselves at edges and
/// vertices.
inline MeshData touching_cells(std::uint32_t cells, unsigned seed) {
  const MeshData grid = unit_cube(cells);
  std::mt19937 random(seed);
  std::vector<bool> kept(cells * cells * cells);
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = random() % 5 < 3;
  kept[0] = true;
  return part_of(grid, [&](const auto& tet) {
    Point centre;
    for (const std::uint32_t v : tet) centre += 0.25 * grid.points[v];
    const auto cell = [&](double x) { return static_cast<std::uint32_t>(x * cells); };
    return kept[(cell(centre.z) * cells + cell(centre.y)) * cells + cell(centre.x)];
  });
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

/// The box [0,1] x [0,1] x [0,2] of jittered tets in `materials` layers along z, tet references 1, 2, ...;
/// triangle references 1 to 6 by side and 10 + i on the interface above layer i.
inline MeshData layered_box(std::uint32_t cells, std::uint32_t cells_per_layer, int materials) {
  meshing::BoxOptions options;
  options.cells = {cells, cells, cells_per_layer * static_cast<std::uint32_t>(materials)};
  options.max = {1, 1, 2};
  MeshData mesh = meshing::structured_box(options);
  const double thickness = 2.0 / materials;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double z = 0;
    for (const std::uint32_t v : mesh.tets[t]) z += mesh.points[v].z / 4;
    mesh.tet_refs[t] = 1 + static_cast<std::int32_t>(z / thickness);
  }
  MeshData faces = mesh;
  faces.triangles.clear();
  faces.triangle_refs.clear();
  add_boundary_triangles(faces);
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    if (faces.triangle_refs[i] != 2) continue;
    mesh.triangles.push_back(faces.triangles[i]);
    const double z = mesh.points[faces.triangles[i][0]].z;
    mesh.triangle_refs.push_back(10 + static_cast<std::int32_t>(std::lround(z / thickness)));
  }
  return mesh;
}

/// n tets around the edge from vertex 0, (0, 0, -height), to vertex 1, (0, 0, height); the ring, vertices 2
/// to n + 1, is a regular polygon of radius 1.
inline MeshData ring_of(std::uint32_t n, double height) {
  std::vector<Point> points{{0, 0, -height}, {0, 0, height}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    points.push_back({std::cos(angle), std::sin(angle), 0});
    tets.push_back({0, 1, 2 + i, 2 + (i + 1) % n});
  }
  return mesh_of(std::move(points), std::move(tets));
}

/// n tets around the boundary edge from vertex 0, (-length, 0, 0), to vertex 1, (length, 0, 0); their ring,
/// vertices 2 to n + 2, is half a circle from (0, 1, 0) over (0, 0, 1) to (0, -1, 0): the base is planar.
inline MeshData half_ring_of(std::uint32_t n, double length) {
  std::vector<Point> points{{-length, 0, 0}, {length, 0, 0}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i <= n; ++i) {
    const double angle = std::numbers::pi * i / n;
    points.push_back({0, i == 0 ? 1 : i == n ? -1 : std::cos(angle), i == 0 || i == n ? 0 : std::sin(angle)});
    if (i < n) tets.push_back({0, 1, 2 + i, 3 + i});
  }
  return mesh_of(std::move(points), std::move(tets));
}

/// Vertex 0 at `centre` in an octahedron of vertices 1 to 6: +x, -x, +y, -y, +z, -z, at distance 1.
inline MeshData octahedron(const Point& centre = {0, 0, 0}) {
  std::vector<Point> points{centre, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t x = 1; x <= 2; ++x)
    for (std::uint32_t y = 3; y <= 4; ++y)
      for (std::uint32_t z = 5; z <= 6; ++z) {
        tets.push_back({0, x, y, z});
        if ((x + y + z) % 2 == 0) std::swap(tets.back()[2], tets.back()[3]);
      }
  return mesh_of(std::move(points), std::move(tets));
}

/// The three tets of the prism from triangle `below` to triangle `above`, cut so that neighbours agree.
inline void add_prism(MeshData& mesh, std::array<std::uint32_t, 3> below,
                      std::array<std::uint32_t, 3> above) {
  // Start at the least vertex below: the diagonals of its two sides leave from it.
  const auto least = std::min_element(below.begin(), below.end()) - below.begin();
  std::rotate(below.begin(), below.begin() + least, below.end());
  std::rotate(above.begin(), above.begin() + least, above.end());
  const auto [a, b, c] = below;
  const auto [d, e, f] = above;
  mesh.tets.push_back({a, d, e, f});
  if (b < c) {
    mesh.tets.push_back({a, b, c, f});
    mesh.tets.push_back({a, b, f, e});
  } else {
    mesh.tets.push_back({a, b, c, e});
    mesh.tets.push_back({a, c, f, e});
  }
  for (auto tet = mesh.tets.end() - 3; tet != mesh.tets.end(); ++tet) {
    const auto& x = mesh.points;
    if (meshing::six_volume(x[(*tet)[0]], x[(*tet)[1]], x[(*tet)[2]], x[(*tet)[3]]) < 0)
      std::swap((*tet)[2], (*tet)[3]);
  }
}

/// The ball of radius 1 in `layers` layers over an icosahedron each of whose triangles is cut into four
/// `subdivisions` times; one smooth boundary patch.
inline MeshData ball(int subdivisions, int layers) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Point> sphere{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                            {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Triangle> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                  {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                  {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                  {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  const auto unit = [](const Point& p) { return (1 / norm(p)) * p; };
  for (Point& p : sphere) p = unit(p);
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(sphere.size()));
      if (fresh) sphere.push_back(unit(meshing::midpoint(sphere[a], sphere[b])));
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const Triangle& t : {Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back(t);
    }
    triangles = std::move(finer);
  }
  const auto n = static_cast<std::uint32_t>(sphere.size());
  MeshData mesh;
  mesh.points.push_back({});
  for (int layer = 1; layer <= layers; ++layer)
    for (const Point& p : sphere) mesh.points.push_back((static_cast<double>(layer) / layers) * p);
  for (std::uint32_t layer = 0; layer < static_cast<std::uint32_t>(layers); ++layer)
    for (Triangle t : triangles) {
      for (std::uint32_t& v : t) v += 1 + layer * n;
      if (layer == 0)
        mesh.tets.push_back({0, t[0], t[1], t[2]});
      else
        add_prism(mesh, {t[0] - n, t[1] - n, t[2] - n}, t);
    }
  mesh.point_refs.assign(mesh.points.size(), 0);
  mesh.tet_refs.assign(mesh.tets.size(), 1);
  add_boundary_triangles(mesh);
  return mesh;
}

/// A cylinder of radius 1 from z = 0 to z = height: `segments` round it, `rings` and `layers`. Triangle
/// references: 1 the side, 2 the bottom, 3 the top.
inline MeshData cylinder(std::uint32_t segments, std::uint32_t rings, std::uint32_t layers, double height) {
  MeshData mesh;
  const std::uint32_t n = 1 + rings * segments;
  for (std::uint32_t k = 0; k <= layers; ++k) {
    const double z = height * k / layers;
    mesh.points.push_back({0, 0, z});
    for (std::uint32_t r = 1; r <= rings; ++r)
      for (std::uint32_t s = 0; s < segments; ++s) {
        const double angle = 2 * std::numbers::pi * s / segments, radius = static_cast<double>(r) / rings;
        mesh.points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
      }
  }
  const auto at = [&](std::uint32_t r, std::uint32_t s) {
    return r == 0 ? 0 : 1 + (r - 1) * segments + s % segments;
  };
  const auto prism = [&](std::array<std::uint32_t, 3> t, std::uint32_t k) {
    add_prism(mesh, {t[0] + k * n, t[1] + k * n, t[2] + k * n},
              {t[0] + (k + 1) * n, t[1] + (k + 1) * n, t[2] + (k + 1) * n});
  };
  for (std::uint32_t k = 0; k < layers; ++k)
    for (std::uint32_t r = 0; r < rings; ++r)
      for (std::uint32_t s = 0; s < segments; ++s) {
        prism({at(r, s), at(r + 1, s), at(r + 1, s + 1)}, k);
        if (r > 0) prism({at(r, s), at(r + 1, s + 1), at(r, s + 1)}, k);
      }
  mesh.point_refs.assign(mesh.points.size(), 0);
  mesh.tet_refs.assign(mesh.tets.size(), 1);
  add_boundary_triangles(mesh);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto all_at = [&](double z) {
      return std::ranges::all_of(mesh.triangles[i], [&](std::uint32_t v) { return mesh.points[v].z == z; });
    };
    mesh.triangle_refs[i] = all_at(0) ? 2 : all_at(height) ? 3 : 1;
  }
  return mesh;
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

/// Point v of `mesh` becomes point old_to_new[v].
inline void renumber_points(MeshData& mesh, const std::vector<std::uint32_t>& old_to_new) {
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
}

/// Renames the vertices and reorders the tets at random: the same mesh without any order to rely on.
inline void shuffle(MeshData& mesh, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> old_to_new(mesh.points.size());
  for (std::uint32_t v = 0; v < old_to_new.size(); ++v) old_to_new[v] = v;
  std::shuffle(old_to_new.begin(), old_to_new.end(), random);
  renumber_points(mesh, old_to_new);
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
