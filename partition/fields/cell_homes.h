// Who has, and who wants, what is in the cells of a grid.
#pragma once

#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/fields/cell_grid.h"

namespace weft::partition {

/// All ranks, with the same grid: for each of the cells in which this rank has something the ranks that want
/// the cell, ascending. Both lists are ascending. A cell has a home rank, at which who wants it asks and who
/// has it learns of that.
std::vector<std::vector<int>> ranks_wanting(Peers& peers, const CellGrid& grid,
                                            const std::vector<std::uint32_t>& had,
                                            const std::vector<std::uint32_t>& wanted);

}  // namespace weft::partition
