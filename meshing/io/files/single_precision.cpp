// What rounding to single precision does to vertices and tets.
#include "meshing/io/files/single_precision.h"

#include <cmath>
#include <limits>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

double rounded(double x) {
  // Volatile, because GCC 12 drops the rounding when it vectorises three of these at once.
  volatile float in_single = static_cast<float>(x);
  return in_single;
}

Point rounded(const Point& p) { return {rounded(p.x), rounded(p.y), rounded(p.z)}; }

bool too_large(const Point& p) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return std::abs(p.x) > kLargest || std::abs(p.y) > kLargest || std::abs(p.z) > kLargest;
}

}  // namespace

void refuse_if_rounding_breaks(std::span<const Point> points, std::uint64_t first_point, std::size_t num_tets,
                               std::uint64_t first_tet,
                               const std::function<std::array<Point, 4>(std::size_t)>& corners,
                               const std::string& file) {
  const std::size_t large = find_first(points.size(), [&](std::size_t v) { return too_large(points[v]); });
  if (large < points.size())
    throw InputError(file, "vertex " + std::to_string(first_point + large + 1),
                     "a coordinate is too large for 32-bit reals");
  const std::size_t bad = find_first(num_tets, [&](std::size_t t) {
    const auto [a, b, c, d] = corners(t);
    return orientation(rounded(a), rounded(b), rounded(c), rounded(d)) <= 0 && orientation(a, b, c, d) > 0;
  });
  if (bad < num_tets)
    throw InputError(file, "tet " + std::to_string(first_tet + bad + 1),
                     "would lose its volume in the 32-bit reals of this format: choose one with 64 bits");
}

void refuse_if_rounding_breaks(const MeshData& mesh, const std::string& file) {
  const auto corners = [&](std::size_t t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    return std::array{mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]};
  };
  refuse_if_rounding_breaks(mesh.points, 0, mesh.tets.size(), 0, corners, file);
}

}  // namespace weft::meshing
