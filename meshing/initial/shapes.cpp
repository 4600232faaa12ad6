// Divides icosahedron faces and cylinder rings; lists and halves the triangles of the delta wing.
#include "meshing/initial/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "meshing/base/error.h"

namespace weft::meshing {
namespace {

void add_triangle(MeshData& m, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::int32_t ref) {
  m.triangles.push_back({a, b, c});
  m.triangle_refs.push_back(ref);
}

std::uint32_t add_point(MeshData& m, const Point& p) {
  m.points.push_back(p);
  m.point_refs.push_back(0);
  return static_cast<std::uint32_t>(m.points.size() - 1);
}

void add_ridge(MeshData& m, std::uint32_t a, std::uint32_t b, std::int32_t ref) {
  m.ridges.push_back(static_cast<std::uint32_t>(m.edges.size()));
  m.edges.push_back({a, b});
  m.edge_refs.push_back(ref);
}

/// Parts that a length is cut into; refuses what would never fit into memory.
std::uint32_t parts(double length, double size, std::uint32_t least) {
  const double n = std::ceil(length / size);
  if (!(n < 8000)) throw InputError("", "size", fmt::format("{:.6g} is too small for this body", size));
  return std::max(least, static_cast<std::uint32_t>(n));
}

/// Points on the sphere, shared between the icosahedron's faces: the corners' weights are their names.
class Icosphere {
 public:
  Icosphere(const BallOptions& options, std::uint32_t n) : options_(options), n_(n) {}

  MeshData build() {
    const double g = std::numbers::phi;
    corners_ = {{{-1, g, 0},
                 {1, g, 0},
                 {-1, -g, 0},
                 {1, -g, 0},
                 {0, -1, g},
                 {0, 1, g},
                 {0, -1, -g},
                 {0, 1, -g},
                 {g, 0, -1},
                 {g, 0, 1},
                 {-g, 0, -1},
                 {-g, 0, 1}}};
    constexpr std::array<Triangle, 20> faces = {{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
    for (const Triangle& f : faces) divide(f);
    return std::move(mesh_);
  }

 private:
  void divide(const Triangle& f) {
    for (std::uint32_t i = 0; i < n_; ++i)
      for (std::uint32_t j = 0; i + j < n_; ++j) {
        add_triangle(mesh_, at(f, i, j), at(f, i + 1, j), at(f, i, j + 1), 1);
        if (i + j + 1 < n_) add_triangle(mesh_, at(f, i + 1, j), at(f, i + 1, j + 1), at(f, i, j + 1), 1);
      }
  }

  std::uint32_t at(const Triangle& f, std::uint32_t i, std::uint32_t j) {
    std::array<std::pair<std::uint32_t, std::uint32_t>, 3> weights = {
        {{f[0], n_ - i - j}, {f[1], i}, {f[2], j}}};
    std::sort(weights.begin(), weights.end());
    std::vector<std::uint32_t> name;
    Vec sum;
    for (const auto& [corner, weight] : weights) {
      if (weight == 0) continue;
      name.insert(name.end(), {corner, weight});
      sum += double(weight) * corners_[corner];
    }
    const auto [found, is_new] = points_.try_emplace(name, 0);
    if (is_new) found->second = add_point(mesh_, options_.center + (options_.radius / norm(sum)) * sum);
    return found->second;
  }

  const BallOptions& options_;
  std::uint32_t n_;
  std::array<Point, 12> corners_;
  std::map<std::vector<std::uint32_t>, std::uint32_t> points_;
  MeshData mesh_;
};

/// A circle of points with `n` of them, around the axis.
std::vector<std::uint32_t> add_circle(MeshData& m, const Point& center, double radius, std::uint32_t n) {
  std::vector<std::uint32_t> circle;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double t = 2 * std::numbers::pi * i / n;
    circle.push_back(add_point(m, center + Vec{radius * std::cos(t), radius * std::sin(t), 0}));
  }
  return circle;
}

/// Triangles between two concentric circles of any numbers of points, upwards; one point stands for a disk's
/// middle.
void add_annulus(MeshData& m, const std::vector<std::uint32_t>& outer,
                 const std::vector<std::uint32_t>& inner, bool up, std::int32_t ref) {
  const auto turned = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    up ? add_triangle(m, a, b, c, ref) : add_triangle(m, b, a, c, ref);
  };
  const std::size_t no = outer.size(), ni = inner.size() > 1 ? inner.size() : 0;
  for (std::size_t i = 0, j = 0; i < no || j < ni;) {
    const bool step_outer = j >= ni || (i < no && (i + 0.5) / double(no) <= (j + 0.5) / double(ni));
    const std::uint32_t a = outer[i % no], b = inner[j % inner.size()];
    if (step_outer)
      turned(a, outer[++i % no], b);
    else
      turned(a, inner[++j % ni], b);
  }
}

/// Rings of about equal edges from the rim to the middle.
void add_disk(MeshData& m, const CylinderOptions& o, const std::vector<std::uint32_t>& rim, double z, bool up,
              std::int32_t ref) {
  const Point center = {o.base.x, o.base.y, z};
  const std::uint32_t rings = parts(o.radius, o.size, 1);
  std::vector<std::uint32_t> outer = rim;
  for (std::uint32_t k = rings - 1; k > 0; --k) {
    const double radius = o.radius * k / rings;
    const auto n = std::max<std::uint32_t>(6, static_cast<std::uint32_t>(double(rim.size()) * k / rings));
    const std::vector<std::uint32_t> inner = add_circle(m, center, radius, n);
    add_annulus(m, outer, inner, up, ref);
    outer = inner;
  }
  add_annulus(m, outer, {add_point(m, center)}, up, ref);
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// The longest edge of a triangle and its length; equal ones are told apart by their vertices.
std::pair<double, Edge> longest_edge(const MeshData& m, const Triangle& t) {
  std::pair<double, Edge> longest;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
    longest = std::max(longest, {norm(m.points[b] - m.points[a]), Edge{a, b}});
  }
  return longest;
}

/// Triangle i becomes its half at the edge's second end; the other half is added.
void halve(MeshData& m, std::uint32_t i, const Edge& edge, std::uint32_t middle) {
  Triangle other = m.triangles[i];
  std::replace(m.triangles[i].begin(), m.triangles[i].end(), edge.first, middle);
  std::replace(other.begin(), other.end(), edge.second, middle);
  add_triangle(m, other[0], other[1], other[2], m.triangle_refs[i]);
}

/// Halves every edge that is longer than `size` and the longest of all its triangles that have a reference up
/// to `last_ref`; false when there is none.
bool halve_long_edges(MeshData& m, double size, std::int32_t last_ref) {
  std::map<Edge, std::vector<std::uint32_t>> triangles_of;
  for (std::uint32_t i = 0; i < m.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      triangles_of[std::minmax(m.triangles[i][k], m.triangles[i][(k + 1) % 3])].push_back(i);
  std::vector<bool> halved(m.triangles.size());
  bool any = false;
  for (const auto& [edge, at] : triangles_of) {
    const double length = norm(m.points[edge.second] - m.points[edge.first]);
    const auto counts = [&](std::uint32_t i) { return m.triangle_refs[i] <= last_ref; };
    const auto refuses = [&](std::uint32_t i) {
      return halved[i] || (counts(i) && longest_edge(m, m.triangles[i]).second != edge);
    };
    if (length <= size || std::none_of(at.begin(), at.end(), counts) ||
        std::any_of(at.begin(), at.end(), refuses))
      continue;
    const std::uint32_t middle = add_point(m, midpoint(m.points[edge.first], m.points[edge.second]));
    for (const std::uint32_t i : at) halve(m, i, edge, middle), halved[i] = true;
    any = true;
  }
  return any;
}

}  // namespace

MeshData ball_surface(const BallOptions& options) {
  constexpr double kIcosahedronEdge = 1.0514622242382672;  // of unit circumradius
  return Icosphere(options, parts(1.1 * kIcosahedronEdge * options.radius, options.size, 1)).build();
}

MeshData cylinder_surface(const CylinderOptions& o) {
  MeshData m;
  const std::uint32_t around = parts(2 * std::numbers::pi * o.radius, o.size, 8);
  const std::uint32_t layers = parts(o.height, o.size, 1);
  std::vector<std::vector<std::uint32_t>> circles;
  for (std::uint32_t k = 0; k <= layers; ++k)
    circles.push_back(add_circle(m, o.base + Vec{0, 0, o.height * k / layers}, o.radius, around));
  for (std::uint32_t k = 0; k < layers; ++k)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t j = (i + 1) % around;
      add_triangle(m, circles[k][i], circles[k][j], circles[k + 1][j], 1);
      add_triangle(m, circles[k][i], circles[k + 1][j], circles[k + 1][i], 1);
    }
  for (std::uint32_t i = 0; i < around; ++i) {
    add_ridge(m, circles[0][i], circles[0][(i + 1) % around], 1);
    add_ridge(m, circles[layers][i], circles[layers][(i + 1) % around], 2);
  }
  add_disk(m, o, circles[0], o.base.z, false, 2);
  add_disk(m, o, circles[layers], o.base.z + o.height, true, 3);
  return m;
}

MeshData delta_wing_surface(const DeltaWingOptions& options) {
  constexpr double t = -0.0244161374866962433, a = 0.157828390598297119, slope = 0.267949223518371582;
  constexpr double x = 6.36942720413208008, y = 5.30785608291625977;
  MeshData m;
  const std::array<Point, 14> points = {{{0, 0, 0},
                                         {1, 0, 0},
                                         {1, 0, t},
                                         {a, 0, t},
                                         {1, slope, 0},
                                         {1, slope * (1 - a), t},  // 0 to 5: the wing
                                         {-x, 0, -y},
                                         {x, 0, -y},
                                         {-x, y, -y},
                                         {x, y, -y},
                                         {-x, 0, y},
                                         {x, 0, y},
                                         {-x, y, y},
                                         {x, y, y}}};
  for (const Point& p : points) add_point(m, p);
  constexpr std::array<std::array<std::uint32_t, 4>, 24> triangles = {
      {{1, 0, 4, 1},   {2, 3, 2, 5},   {3, 0, 5, 4},     {3, 0, 3, 5},     {4, 1, 5, 2},   {4, 1, 4, 5},
       {5, 6, 10, 12}, {5, 6, 12, 8},  {6, 7, 9, 13},    {6, 7, 13, 11},   {8, 8, 12, 13}, {8, 8, 13, 9},
       {9, 6, 8, 9},   {9, 6, 9, 7},   {10, 10, 11, 13}, {10, 10, 13, 12}, {7, 6, 3, 0},   {7, 6, 0, 10},
       {7, 10, 0, 1},  {7, 10, 1, 11}, {7, 11, 1, 7},    {7, 1, 2, 7},     {7, 7, 2, 3},   {7, 7, 3, 6}}};
  for (const auto& [ref, p, q, r] : triangles) add_triangle(m, p, q, r, static_cast<std::int32_t>(ref));
  constexpr std::int32_t last_of_wing = 4;
  if (options.size > 0) parts(1, options.size, 1);
  while (options.size > 0 && halve_long_edges(m, options.size, last_of_wing)) {
  }
  return m;
}

}  // namespace weft::meshing
