// Edge split: a vertex is created on an edge and every tet of the shell becomes two.
#pragma once

#include "meshing/kernel.h"

namespace weft::meshing {

/// What a split may not do.
struct SplitBounds {
  double shortest;  ///< no new edge shorter than this
  double keep_share =
      0.8;  ///< no new tet worse than limits.split_quality unless better than this share of the worst before
};

/// Splits edge (a, b) of the claimed tet `t` at its middle in the metric; on curved boundary the new vertex
/// is put on the reference surface. Refuses what would invert or break `bounds`. All touched vertices stay
/// claimed; the caller releases.
Verdict split_edge(Worker& w, TetId t, VertexId a, VertexId b, const SplitBounds& bounds);

}  // namespace weft::meshing
