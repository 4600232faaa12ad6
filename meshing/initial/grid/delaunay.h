// Delaunay tetrahedrisation of a point set inside a surrounding box, by insertion (Bowyer 1981, Watson 1981).
#pragma once

#include <atomic>
#include <span>

#include "meshing/initial/grid/tet_grid.h"

namespace weft::meshing {

/// The points, numbered as given, and after them the 8 corners of a box around them: every point is inside.
/// Exact predicates throughout; the points must differ. The same input gives the same tets.
/// The grid keeps the flag `interrupt` and throws Interrupted once it is set.
TetGrid delaunay_in_box(std::span<const Point> points, const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::meshing
