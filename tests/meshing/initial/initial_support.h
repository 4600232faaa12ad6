// Small surfaces for the tests of initial meshes, and what they enclose.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "meshing/initial/shapes.h"
#include "meshing/mesh/mesh_data.h"

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

/// Closed triangle (a, b, c), counter-clockwise, holds p.
inline bool triangle_holds(const Point& a, const Point& b, const Point& c, const Point& p) {
  const auto turn = [](const Point& u, const Point& v, const Point& w) {
    return (v.x - u.x) * (w.y - u.y) - (v.y - u.y) * (w.x - u.x);
  };
  return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

/// A triangulation of a simple polygon in the xy-plane, counter-clockwise, without more vertices: its ears
/// cut in random order, so that needles cross the whole of it.
inline std::vector<std::array<std::uint32_t, 3>> random_ears(const std::vector<Point>& polygon,
                                                             std::mt19937& random) {
  std::vector<std::uint32_t> rest(polygon.size());
  for (std::uint32_t i = 0; i < rest.size(); ++i) rest[i] = i;
  std::vector<std::array<std::uint32_t, 3>> ears;
  while (rest.size() > 2) {
    const std::size_t n = rest.size(), start = random() % n;
    std::size_t found = n;
    for (std::size_t k = start; k < start + n && found == n; ++k) {
      const std::array<std::uint32_t, 3> t = {rest[(k + n - 1) % n], rest[k % n], rest[(k + 1) % n]};
      const Point &a = polygon[t[0]], &b = polygon[t[1]], &c = polygon[t[2]];
      if ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) <= 1e-12) continue;
      const bool blocked = std::any_of(rest.begin(), rest.end(), [&](std::uint32_t v) {
        return v != t[0] && v != t[1] && v != t[2] && triangle_holds(a, b, c, polygon[v]);
      });
      if (!blocked) found = k % n, ears.push_back(t);
    }
    if (found == n) return {};
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(found));
  }
  return ears;
}

/// A prism of height 1 on a polygon, its ends in needles that differ; reference 1 side, 2 and 3 ends.
inline MeshData prism(const std::vector<Point>& polygon, std::mt19937& random) {
  MeshData m;
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (const double z : {0.0, 1.0})
    for (const Point& p : polygon) m.points.push_back({p.x, p.y, z});
  m.point_refs.assign(m.points.size(), 0);
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, int ref) {
    m.triangles.push_back({a, b, c});
    m.triangle_refs.push_back(ref);
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    add(i, j, n + j, 1);
    add(i, n + j, n + i, 1);
  }
  for (const auto& [a, b, c] : random_ears(polygon, random)) add(a, c, b, 2);
  for (const auto& [a, b, c] : random_ears(polygon, random)) add(n + a, n + b, n + c, 3);
  return m;
}

/// A gear's outline: `teeth` teeth of four points each, counter-clockwise.
inline std::vector<Point> gear_outline(int teeth) {
  std::vector<Point> polygon;
  for (int i = 0; i < 4 * teeth; ++i) {
    const double angle = 2 * std::numbers::pi * i / (4 * teeth), radius = i % 4 < 2 ? 1 : 0.8;
    polygon.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  return polygon;
}

/// A unit square with points at random places of its sides.
inline std::vector<Point> square_outline(std::size_t points_a_side, std::mt19937& random) {
  std::uniform_real_distribution<double> at(0.001, 0.999);
  std::vector<Point> polygon;
  for (int side = 0; side < 4; ++side) {
    std::vector<double> places = {0};
    for (std::size_t i = 0; i < points_a_side; ++i) places.push_back(at(random));
    std::sort(places.begin(), places.end());
    for (const double x : places)
      polygon.push_back(side == 0   ? Point{x, 0, 0}
                        : side == 1 ? Point{1, x, 0}
                        : side == 2 ? Point{1 - x, 1, 0}
                                    : Point{0, 1 - x, 0});
  }
  return polygon;
}

/// Turned by random angles: planes are planes up to rounding only.
inline MeshData turned(MeshData m, std::mt19937& random) {
  std::uniform_real_distribution<double> angle(0, 6);
  const double a = angle(random), b = angle(random);
  for (Point& p : m.points) {
    p = {std::cos(a) * p.x - std::sin(a) * p.y, std::sin(a) * p.x + std::cos(a) * p.y, p.z};
    p = {p.x, std::cos(b) * p.y - std::sin(b) * p.z, std::sin(b) * p.y + std::cos(b) * p.z};
  }
  return m;
}

/// A torus of radii 1 and 0.5, as coarse as `along` pieces along it and `around` pieces around its tube say.
/// Coordinates are those of single precision.
inline MeshData torus(std::uint32_t along, std::uint32_t around) {
  MeshData m;
  for (std::uint32_t i = 0; i < along; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const double a = 2 * std::numbers::pi * i / along, b = 2 * std::numbers::pi * j / around,
                   radius = 1 + 0.5 * std::cos(b);
      const auto rounded = [](double x) { return double{static_cast<float>(x)}; };
      m.points.push_back(
          {rounded(radius * std::cos(a)), rounded(radius * std::sin(a)), rounded(0.5 * std::sin(b))});
      const auto at = [&](std::uint32_t k, std::uint32_t l) {
        return (i + k) % along * around + (j + l) % around;
      };
      m.triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
      m.triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  m.point_refs.assign(m.points.size(), 0);
  m.triangle_refs.assign(m.triangles.size(), 1);
  return m;
}

inline MeshData ball(double size, const Point& center = {}, double radius = 1) {
  return meshing::ball_surface({center, radius, size});
}

}  // namespace weft::support
