// A mesh and its solution fields as files hold them: plain arrays, 0-based, no connectivity.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/base/point.h"

namespace weft::meshing {

/// A tetrahedral mesh as read from or written to a file. Every `*_refs` array has the length of its
/// entity array. Indices are 0-based into `points`.
struct MeshData {
  std::vector<Point> points;
  std::vector<std::int32_t> point_refs;
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::int32_t> tet_refs;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::int32_t> triangle_refs;
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::int32_t> edge_refs;
  std::vector<std::uint32_t> corners;             ///< indices of points
  std::vector<std::uint32_t> required_points;     ///< indices of points
  std::vector<std::uint32_t> ridges;              ///< indices of edges
  std::vector<std::uint32_t> required_edges;      ///< indices of edges
  std::vector<std::uint32_t> required_triangles;  ///< indices of triangles
};

/// One field of a solution file: `values` holds components(kind) doubles per vertex, row after row.
/// A symmetric tensor is stored as m11 m12 m22 m13 m23 m33.
struct Field {
  enum class Kind { scalar = 1, vector = 2, tensor = 3 };
  Kind kind = Kind::scalar;
  std::vector<double> values;
  std::string name;  ///< from formats that have names; empty in GMF
};

inline int components(Field::Kind kind) {
  return kind == Field::Kind::scalar ? 1 : kind == Field::Kind::vector ? 3 : 6;
}

/// The fields at the vertices of one mesh.
struct SolutionData {
  std::size_t num_points = 0;
  std::vector<Field> fields;
};

}  // namespace weft::meshing
