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

void refuse_if_rounding_breaks(const MeshData& mesh, const std::string& file) {
  const std::size_t large =
      find_first(mesh.points.size(), [&](std::size_t v) { return too_large(mesh.points[v]); });
  if (large < mesh.points.size())
    throw InputError(file, "vertex " + std::to_string(large + 1),
                     "a coordinate is too large for 32-bit reals");
  const std::size_t bad = find_first(mesh.tets.size(), [&](std::size_t t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    const auto& p = mesh.points;
    return orientation(rounded(p[a]), rounded(p[b]), rounded(p[c]), rounded(p[d])) <= 0 &&
           orientation(p[a], p[b], p[c], p[d]) > 0;
  });
  if (bad < mesh.tets.size())
    throw InputError(file, "tet " + std::to_string(bad + 1),
                     "would lose its volume in the 32-bit reals of this format: choose one with 64 bits");
}

}  // namespace weft::meshing
