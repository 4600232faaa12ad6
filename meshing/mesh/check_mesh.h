// The independent full check of a mesh: what `weft verify`, the tests and heavy assertions use.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/problems.h"

namespace weft::meshing {

/// What check_mesh found. `problems` holds at most `max_problems` sentences naming the entities (1-based, as
/// in files), in an order that does not depend on the number of threads.
struct CheckReport {
  std::vector<std::string> problems;
  std::uint64_t num_problems = 0;
  std::uint64_t num_components = 0;              ///< of tets connected through faces
  double volume = 0;                             ///< of all tets
  std::map<std::int32_t, double> volume_by_ref;  ///< tet reference -> volume
  std::map<std::int32_t, double> area_by_ref;    ///< triangle reference -> area
  std::uint64_t unreferenced_points = 0;         ///< points of no tet; not a problem, only counted
  bool ok() const { return num_problems == 0; }
};

/// Checks, from the plain arrays alone: as many references as entities; indices in range; different vertices
/// in every tet, triangle and edge; coordinates finite; corners, required entities and ridges in range. Where
/// one of these fails the rest would mean nothing: it is left out, and the figures stay zero. Then: every tet
/// exactly POSITIVE (exact orientation); no duplicate tets; every face in one or two tets, and in two tets
/// that lie on its two sides; every face of one tet, and every face between tets of different references, has
/// exactly one triangle; every triangle is the face of a tet; no duplicate triangles; edges are edges of
/// triangles or tets. The triangles of every component's boundary then form a closed surface, because the
/// boundary of a set of tets has no boundary itself. Sums volumes and areas with compensated summation, so
/// that comparisons at 1e-9 mean something. Multithreaded on TBB (in the caller's arena); 70 bytes a tet of
/// temporaries.
CheckReport check_mesh(const MeshData& mesh, int max_problems = 20);

/// The first of these checks alone, up to the lists being in range.
void check_arrays(const MeshData& mesh, Problems& problems);

}  // namespace weft::meshing
