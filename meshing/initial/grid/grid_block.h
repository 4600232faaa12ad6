// A grid in blocks that threads change at the same time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/initial/grid/tet_grid.h"

namespace weft::meshing {

/// A part of a grid, as a grid of its own. Its first tets, `frozen`, share faces with other blocks: they must
/// stay, and what would take them away is for later.
struct GridBlock {
  TetGrid grid;
  std::uint32_t frozen = 0;
  std::vector<std::uint32_t> tets, vertices;  ///< their numbers in the whole grid
};

/// The whole grid's numbers of a block's points and tets, with those that the block has made.
struct JoinedNumbers {
  std::vector<std::uint32_t> points, tets;
};

/// Blocks of about as many tets each, by planes. Points must stand where doubles say.
std::vector<GridBlock> divide(const TetGrid& grid, std::size_t count);

/// Puts the blocks back into the grid that they come from.
std::vector<JoinedNumbers> join(TetGrid& grid, std::span<const GridBlock> blocks);

}  // namespace weft::meshing
