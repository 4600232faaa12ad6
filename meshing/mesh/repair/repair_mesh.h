// Mends of meshes that the kernel refuses.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// One kind of mend, what it was done to, and the largest change that it made.
struct MeshMend {
  std::string what, entity;
  std::uint64_t count = 0;
  std::vector<std::uint64_t> examples;  ///< the first of them, 1-based in the input
  double amount = 0;
  std::string unit;  ///< of the amount; empty: there is none

  /// Counts one more.
  void add(std::uint64_t index, double change = 0);
};

struct MeshRepair {
  std::vector<MeshMend> mends;
  std::vector<std::uint32_t> points;  ///< of each point of the result: its number in the input
};

/// In this order: merges vertices at the same place (within 1e-12 of the diagonal), where no tet with volume
/// collapses; removes tets with a repeated vertex and those that are there twice (the first one's reference
/// counts); makes vertices one that are nearly at the same place on both sides of a crack (close_cracks.h);
/// joins hanging vertices (join_hanging.h); removes a tet that overlaps others and hangs on one face alone;
/// turns tets whose vertices are listed the wrong way round; untangles tets that lie the wrong way round, or
/// flat, by moving vertices that are no vertices of triangles or of the boundary; removes tets that are flat
/// and lie at the boundary; untangles what is left by moving vertices within smooth parts of the boundary too
/// (untangle.h); removes triangles that are no faces, or are there twice (the first one's reference counts,
/// and the marks of both), edges and marks of what is no more, and unused vertices; and lists the triangles
/// that are missing, with the references of those they replace, or of those beside them in their plane.
/// Throws InputError (no file name) for what is left.
MeshRepair repair_mesh(MeshData& mesh);

}  // namespace weft::meshing
