// Points within a volume, so dense as its surface wants them.
#pragma once

#include <atomic>
#include <span>

#include "meshing/initial/grid/tet_grid.h"
#include "meshing/initial/spread_sizes.h"

namespace weft::meshing {

/// Fills the volumes between the grid's facets with points that are about as far from each other as sizes
/// say which spread from the surface, from the surface inwards. `sizes`: what is known at the grid's
/// vertices; `sources`: where they come from; `largest`: no size is above it. Returns the sizes at the grid's
/// vertices now. Facets stay. More than one of `threads` work in blocks first, if there are tets enough, in
/// the caller's arena; the same number gives the same grid. Ends early, with a whole grid, once `interrupt`
/// (unless null) is set.
std::vector<SpreadSize> insert_inner_points(TetGrid& grid, std::span<const SizeSource> sources,
                                            std::vector<SpreadSize> sizes, double largest, int threads,
                                            const std::atomic<bool>* interrupt);

}  // namespace weft::meshing
