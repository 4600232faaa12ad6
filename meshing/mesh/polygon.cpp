// Dynamic programming over all chords of a loop; and fans that fold over.
#include "meshing/mesh/polygon.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace weft::meshing {
namespace {

Vec normal(std::span<const Point> points, const Triangle& t) {
  return cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
}

/// Whether a triangle of the fan looks against the polygon, whose normal is the sum of the fan's.
bool folds(std::span<const Point> points, std::span<const Triangle> fan) {
  Vec sum;
  for (const Triangle& t : fan) sum = sum + normal(points, t);
  for (const Triangle& t : fan)
    if (dot(normal(points, t), sum) < 0) return true;
  return false;
}

}  // namespace

std::vector<Triangle> triangulate_loop(std::span<const Point> points, std::span<const std::uint32_t> loop) {
  const std::size_t n = loop.size();
  const auto area = [&](std::size_t i, std::size_t k, std::size_t j) {
    return norm(normal(points, {loop[i], loop[k], loop[j]}));
  };
  std::vector<double> least(n * n, 0);
  std::vector<std::uint32_t> choice(n * n, 0);
  for (std::size_t width = 2; width < n; ++width)
    for (std::size_t i = 0; i + width < n; ++i) {
      const std::size_t j = i + width;
      least[i * n + j] = std::numeric_limits<double>::max();
      choice[i * n + j] = static_cast<std::uint32_t>(i + 1);  // areas may be too large for doubles
      for (std::size_t k = i + 1; k < j; ++k) {
        const double sum = least[i * n + k] + least[k * n + j] + area(i, k, j);
        if (sum < least[i * n + j]) least[i * n + j] = sum, choice[i * n + j] = static_cast<std::uint32_t>(k);
      }
    }
  std::vector<Triangle> triangles;
  std::vector<std::pair<std::size_t, std::size_t>> left = {{0, n - 1}};
  while (!left.empty()) {
    const auto [i, j] = left.back();
    left.pop_back();
    if (j < i + 2) continue;
    const std::size_t k = choice[i * n + j];
    triangles.push_back({loop[i], loop[k], loop[j]});
    left.emplace_back(i, k);
    left.emplace_back(k, j);
  }
  return triangles;
}

void Polygons::add(std::span<const std::uint32_t> corners, std::int32_t ref, MeshData& mesh) {
  if (corners.size() > 3) fans_.push_back({mesh.triangles.size(), corners.size() - 2});
  for (std::size_t i = 2; i < corners.size(); ++i) {
    mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    mesh.triangle_refs.push_back(ref);
  }
}

void Polygons::unfold(MeshData& mesh) const {
  constexpr std::size_t kMost = 2000;  // corners: the table of chords grows with their square
  for (const Fan& fan : fans_) {
    const std::span<Triangle> triangles(&mesh.triangles[fan.first], fan.size);
    if (fan.size > kMost || !folds(mesh.points, triangles)) continue;
    std::vector<std::uint32_t> loop = {triangles[0][0], triangles[0][1]};
    for (const Triangle& t : triangles) loop.push_back(t[2]);
    std::ranges::copy(triangulate_loop(mesh.points, loop), triangles.begin());
  }
}

}  // namespace weft::meshing
