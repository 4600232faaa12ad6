// Renumbering by places in the metric, for locality, and without holes.
#pragma once

#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// Orders vertices by halves, each range across the direction in which it is longest in its metric, tets by
/// their first vertex in that order, and closes all holes. Ids change; free-slot lists kept elsewhere become
/// invalid.
void renumber_along_curve(TetMesh& mesh);

/// Whether most tets have a vertex of the one before them, and vertices with numbers near each other: what is
/// used together lies together, though some is elsewhere. In a subdomain that is a stretch of a file of
/// pieces, say, the interface's vertices come first.
bool is_in_order(const TetMesh& mesh);

}  // namespace weft::meshing
