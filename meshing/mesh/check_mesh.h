// The independent full check of a mesh: what `weft verify`, the tests and heavy assertions use.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/problems.h"
#include "weft/data.h"

namespace weft::meshing {

/// Checks, from the plain arrays alone: as many references as entities; indices in range; different vertices
/// in every tet, triangle and edge; coordinates finite; corners, required entities and ridges in range. Where
/// one of these fails the rest would mean nothing: it is left out, and the figures stay zero. Then: every tet
/// exactly POSITIVE (exact orientation); no duplicate tets; every face in one or two tets, and in two tets
/// that lie on its two sides; every face of one tet, and every face between tets of different references, has
/// exactly one triangle; every triangle is the face of a tet; no duplicate triangles; edges are edges of
/// triangles or tets. The triangles of every component's boundary then form a closed surface, because the
/// boundary of a set of tets has no boundary itself, but it may touch itself at edges and vertices: that is
/// counted, and no problem of a mesh alone, for domains may be so (two cells of a chessboard). Sums volumes
/// and areas with compensated summation, so that comparisons at 1e-9 mean something. Multithreaded on TBB (in
/// the caller's arena); 90 bytes a tet of temporaries.
CheckReport check_mesh(const MeshData& mesh, int max_problems = 20);

/// Triangles that have a vertex twice.
enum class CollapsedTriangles { refused, allowed };

/// The first of these checks alone, up to the lists being in range.
void check_arrays(const MeshData& mesh, Problems& problems,
                  CollapsedTriangles collapsed = CollapsedTriangles::refused);

}  // namespace weft::meshing
