// Meshes that rounding makes hard: turned, and with tets that are all but flat.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::support {

/// Turned about no axis in particular: what was in one plane is so to rounding only.
inline meshing::MeshData turned(meshing::MeshData mesh) {
  const double c = std::cos(0.7), s = std::sin(0.7);
  for (meshing::Point& p : mesh.points) {
    p = {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    p = {p.x, c * p.y - s * p.z, s * p.y + c * p.z};
  }
  return mesh;
}

/// Every third tet is divided at a point that lies on one of its faces but for rounding; its parts are
/// exactly positive. Inner points and tets only; no boundary entities.
inline meshing::MeshData with_slivers(const meshing::MeshData& mesh, unsigned seed) {
  using meshing::Point;
  std::mt19937 random(seed);
  meshing::MeshData result;
  result.points = mesh.points;
  for (const meshing::Tet& tet : mesh.tets) {
    const std::size_t flat = random() % 12;
    std::vector<meshing::Tet> parts{tet};
    if (flat < 4) {
      const auto& f = meshing::kTetFaces[flat];
      Point p;
      for (const int i : f) p += (1.0 / 3) * mesh.points[tet[static_cast<std::size_t>(i)]];
      std::vector<meshing::Tet> divided;
      bool positive = true;
      for (const auto& g : meshing::kTetFaces) {
        const auto at = [&](std::size_t i) { return tet[static_cast<std::size_t>(g[i])]; };
        positive &= orientation(mesh.points[at(0)], mesh.points[at(1)], mesh.points[at(2)], p) > 0;
        divided.push_back({at(0), at(1), at(2), static_cast<std::uint32_t>(result.points.size())});
      }
      if (positive) {
        result.points.push_back(p);
        parts = std::move(divided);
      }
    }
    result.tets.insert(result.tets.end(), parts.begin(), parts.end());
  }
  result.point_refs.assign(result.points.size(), 0);
  result.tet_refs.assign(result.tets.size(), 1);
  return result;
}

}  // namespace weft::support
