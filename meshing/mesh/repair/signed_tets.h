// Volumes and signs of tets, and their faces.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {

inline double volume(const MeshData& m, const Tet& t) {
  const auto& p = m.points;
  return dot(p[t[1]] - p[t[0]], cross(p[t[2]] - p[t[0]], p[t[3]] - p[t[0]])) / 6;
}

/// Exact.
inline int sign_of(const MeshData& m, const Tet& t) {
  return orientation(m.points[t[0]], m.points[t[1]], m.points[t[2]], m.points[t[3]]);
}

inline Triangle face_of(const Tet& t, int f) {
  return {t[kTetFaces[f][0]], t[kTetFaces[f][1]], t[kTetFaces[f][2]]};
}

/// Those that are inverted or flat.
inline std::vector<std::uint32_t> tets_not_positive(const MeshData& m) {
  std::vector<std::uint32_t> tets;
  for (std::uint32_t t = 0; t < m.tets.size(); ++t)
    if (sign_of(m, m.tets[t]) <= 0) tets.push_back(t);
  return tets;
}

}  // namespace weft::meshing
