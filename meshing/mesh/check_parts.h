// The checks of check_mesh() on a mesh in parts, step by step: who has the parts puts together what they find
// (partition/verify/verify_slices.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/problems.h"

namespace weft::meshing {

/// All tets at the vertices of a range. What is checked here belongs to these vertices: a face or an edge to
/// its least one.
struct Stars {
  const MeshData& mesh;  ///< vertices numbered as in the whole mesh; triangles at the vertices; no points
  std::span<const std::int8_t> signs;          ///< of the tets' orientations
  std::span<const std::uint64_t> tet_numbers;  ///< in the whole mesh, ascending
  std::uint32_t first, end;                    ///< the vertices
};

struct StarsReport {
  Problems problems;                     ///< of faces, in the order of check_mesh()
  std::vector<std::uint8_t> matched;     ///< triangles that are faces of these tets
  std::vector<std::uint32_t> component;  ///< for each tet the least of those that it is joined with here
  std::uint64_t touching_edges = 0;
  std::uint64_t balls = 0;  ///< sets of tets joined around a vertex
  std::uint64_t used = 0;   ///< vertices with tets
};

/// 100 bytes a tet of temporaries; multithreaded.
StarsReport check_stars(const Stars& stars, std::size_t max_problems);

}  // namespace weft::meshing
