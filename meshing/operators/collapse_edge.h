// Edge collapse: a vertex is pulled into a neighbour and the tets of their shell vanish.
#pragma once

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// What a collapse must achieve.
enum class CollapseGoal {
  length,   ///< remove a short edge; quality may fall to limits.collapse_quality
  quality,  ///< the worst tet of the ball must become better
  room,     ///< a vertex is given up for what its place is wanted for: lengths do not matter
  undo,     ///< a split is taken back: any valid result will do
};

/// Collapses `removed`, whose ball has been gathered in w.ball, into its neighbour `kept`. The removed vertex
/// must be free to go that way: along its curve, along its patch, or anywhere from the interior. All touched
/// vertices stay claimed; the caller releases.
Verdict collapse_edge(Worker& w, VertexId removed, VertexId kept, CollapseGoal goal);

}  // namespace weft::meshing
