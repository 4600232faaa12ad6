#include "meshing/initial/mending/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace weft::meshing {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint32_t kLeafTriangles = 8;
constexpr double kFar = 2.5;  // of a box's radius: with one dipole a box, errors stay below about 0.01

}  // namespace

WindingNumber::WindingNumber(std::span<const Point> points, std::span<const Triangle> triangles,
                             std::span<const std::int32_t> sheets)
    : points_(points), triangles_(triangles), sheets_(sheets), order_(triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.emplace_back();
  build(0, 0, static_cast<std::uint32_t>(order_.size()));
}

void WindingNumber::summarise(Node& node, std::uint32_t begin, std::uint32_t end) const {
  double area = 0;
  for (std::uint32_t i = begin; i < end; ++i) {
    const auto& t = triangles_[order_[i]];
    const Point &a = points_[t[0]], &b = points_[t[1]], &c = points_[t[2]];
    const Vec normal = 0.5 * cross(b - a, c - a);
    const double size = norm(normal);
    node.dipole += static_cast<double>(sheets_[order_[i]]) * normal;
    node.centre += (size / 3) * (a + b + c);
    area += size;
    for (const std::uint32_t v : t) node.box.include(points_[v]);
  }
  node.centre = area > 0 ? (1 / area) * node.centre : midpoint(node.box.lo, node.box.hi);
  const auto reach = [&](int i) {
    return std::max(node.box.hi[i] - node.centre[i], node.centre[i] - node.box.lo[i]);
  };
  if (end > begin) node.radius = norm(Vec{reach(0), reach(1), reach(2)});
}

void WindingNumber::build(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
  summarise(nodes_[node], begin, end);
  if (end - begin <= kLeafTriangles) {
    nodes_[node].first = begin;
    nodes_[node].count = end - begin;
    return;
  }
  const Vec size = nodes_[node].box.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto where = [&](std::uint32_t i) {
    const auto& t = triangles_[i];
    return points_[t[0]][axis] + points_[t[1]][axis] + points_[t[2]][axis];
  };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = where(a), y = where(b);
                     return x != y ? x < y : a < b;
                   });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = children;
  build(children, begin, middle);
  build(children + 1, middle, end);
}

/// Van Oosterom and Strackee (1983).
double WindingNumber::solid_angle(std::uint32_t t, const Point& p) const {
  const auto& v = triangles_[t];
  const Vec a = points_[v[0]] - p, b = points_[v[1]] - p, c = points_[v[2]] - p;
  const double la = norm(a), lb = norm(b), lc = norm(c);
  return 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

double WindingNumber::at(const Point& p, std::uint32_t on) const {
  double sum = 0;
  std::vector<std::uint32_t> left = {0};
  while (!left.empty()) {
    const Node& node = nodes_[left.back()];
    left.pop_back();
    const Vec way = node.centre - p;
    const double distance = norm(way);
    if (distance > kFar * node.radius) {
      sum += dot(node.dipole, way) / (distance * distance * distance);
    } else if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        if (order_[i] != on) sum += sheets_[order_[i]] * solid_angle(order_[i], p);
    } else {
      left.push_back(node.first);
      left.push_back(node.first + 1);
    }
  }
  return sum / (4 * kPi);
}

}  // namespace weft::meshing
