// Wishes and offers meet at the homes of cells.
#include "partition/fields/cell_homes.h"

#include <algorithm>
#include <compare>
#include <utility>

#include "meshing/base/place_in.h"

namespace weft::partition {
namespace {

/// Cells have their homes in blocks.
std::size_t home_of(std::uint32_t cell, const CellGrid& grid, int ranks) {
  return static_cast<std::size_t>(std::uint64_t{cell} * static_cast<std::uint64_t>(ranks) / grid.size());
}

std::vector<std::vector<std::uint32_t>> to_homes(const std::vector<std::uint32_t>& cells,
                                                 const CellGrid& grid, int ranks) {
  std::vector<std::vector<std::uint32_t>> to_each(static_cast<std::size_t>(ranks));
  for (const std::uint32_t cell : cells) to_each[home_of(cell, grid, ranks)].push_back(cell);
  return to_each;
}

struct Wish {
  std::uint32_t cell, rank;
  auto operator<=>(const Wish&) const = default;
};

}  // namespace

std::vector<std::vector<int>> ranks_wanting(Peers& peers, const CellGrid& grid,
                                            const std::vector<std::uint32_t>& had,
                                            const std::vector<std::uint32_t>& wanted) {
  const auto wanted_here = partition::all_to_all(peers, to_homes(wanted, grid, peers.ranks()));
  std::vector<Wish> wishes;
  for (std::uint32_t r = 0; r < wanted_here.size(); ++r)
    for (const std::uint32_t cell : wanted_here[r]) wishes.push_back({cell, r});
  std::ranges::sort(wishes);
  const auto had_here = partition::all_to_all(peers, to_homes(had, grid, peers.ranks()));
  std::vector<std::vector<Wish>> replies(had_here.size());
  for (std::size_t r = 0; r < had_here.size(); ++r)
    for (const std::uint32_t cell : had_here[r]) {
      const auto of_cell = std::ranges::equal_range(wishes, cell, {}, &Wish::cell);
      replies[r].insert(replies[r].end(), of_cell.begin(), of_cell.end());
    }
  std::vector<std::vector<int>> result(had.size());
  for (const std::vector<Wish>& of_home : partition::all_to_all(peers, std::move(replies)))
    for (const Wish& wish : of_home)
      result[meshing::place_in(had, wish.cell)].push_back(static_cast<int>(wish.rank));
  return result;
}

}  // namespace weft::partition
