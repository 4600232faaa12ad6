// Small surfaces for the tests of initial meshes, and what they enclose.
#pragma once

#include <cmath>
#include <cstdint>

#include "meshing/initial/shapes.h"
#include "meshing/mesh_data.h"

namespace weft::support {

using meshing::MeshData;
using meshing::Point;

/// A box of n x n squares a side, two triangles each, turned outwards; reference 1 to 6.
inline MeshData box_surface(const Point& lo, const Point& hi, std::uint32_t n) {
  MeshData m;
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      const auto first = static_cast<std::uint32_t>(m.points.size());
      const int u = (axis + 1 + !side) % 3, v = (axis + 2 - !side) % 3;
      for (std::uint32_t j = 0; j <= n; ++j)
        for (std::uint32_t i = 0; i <= n; ++i) {
          Point p = side ? hi : lo;
          p[u] = i == n ? hi[u] : lo[u] + (hi[u] - lo[u]) * i / n;
          p[v] = j == n ? hi[v] : lo[v] + (hi[v] - lo[v]) * j / n;
          m.points.push_back(p);
          m.point_refs.push_back(0);
        }
      for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
          const std::uint32_t a = first + i + j * (n + 1), b = a + n + 1;
          m.triangles.push_back({a, a + 1, b + 1});
          m.triangles.push_back({a, b + 1, b});
          m.triangle_refs.insert(m.triangle_refs.end(), 2, 2 * axis + side + 1);
        }
    }
  return m;
}

/// Both surfaces in one; points are not shared.
inline MeshData together(MeshData a, const MeshData& b) {
  const auto shift = static_cast<std::uint32_t>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  a.point_refs.insert(a.point_refs.end(), b.point_refs.begin(), b.point_refs.end());
  for (const auto& [x, y, z] : b.triangles) a.triangles.push_back({x + shift, y + shift, z + shift});
  a.triangle_refs.insert(a.triangle_refs.end(), b.triangle_refs.begin(), b.triangle_refs.end());
  return a;
}

/// The volume that triangles turned outwards enclose.
inline double enclosed_volume(const MeshData& m) {
  double sum = 0;
  for (const auto& [a, b, c] : m.triangles) sum += dot(m.points[a], cross(m.points[b], m.points[c]));
  return sum / 6;
}

inline MeshData ball(double size, const Point& center = {}, double radius = 1) {
  return meshing::ball_surface({center, radius, size});
}

}  // namespace weft::support
