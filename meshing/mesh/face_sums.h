// Whether a mesh conforms, by sums: for a fiftieth of an adaptation's time, so that every result is checked.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// All zero for a mesh that conforms. Of a mesh in parts each part has its own; they add up.
struct FaceSums {
  /// Points that are not finite, tets that are not exactly positive, triangles that are no face of a tet or
  /// on the same side of two, or given twice, and indices out of range.
  std::uint64_t faults = 0;
  /// Hashes of all faces of tets that have no triangle, with the sign of their orientation, modulo 2^64: what
  /// is left of the boundary of a chain. The two sides of a face cancel.
  std::uint64_t faces = 0;
  /// The same, each times a hash of its tet's reference: faces between different references do not cancel.
  std::uint64_t references = 0;

  bool ok() const { return faults == 0 && faces == 0 && references == 0; }
  FaceSums& operator+=(const FaceSums& other);
};

/// Finds what check_mesh() finds of tets, faces and triangles, but for faces with as many tets too many on
/// one side as on the other; that sums vanish by chance has a probability of 2^-64. Says nothing of edges,
/// and does not name what is wrong. `ids`: of the points, the same for copies in other parts; empty: of a
/// whole mesh. `outer`, unless null, gets 1 for each triangle with a tet on one side only, 0 for the others.
/// Multithreaded (in the caller's arena), the same on any number of threads.
FaceSums sum_faces(const MeshData& mesh, std::span<const std::uint64_t> ids = {},
                   std::vector<std::uint8_t>* outer = nullptr);

/// Sides of faces that two tets and more are on: what the sums do not see where both sides have as many. A
/// mesh overlaps itself there, in positive tets, which it cannot unless a curved boundary has folded: worth
/// the look where the boundary is curved. Multithreaded. Memory: 32 bytes a tet, 8 a point.
std::uint64_t crowded_sides(const MeshData& mesh);

}  // namespace weft::meshing
