// Cells that many boxes touch: those that each of them touches, in a time that does not grow with their size.
#include "partition/fields/cell_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace weft::partition::cell_grid_test {
namespace {

using meshing::Box;
using meshing::Point;

/// Of all sizes, some of them outside of the unit box, some empty.
std::vector<Box> random_boxes(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.2, 1.2), exponent(-9, 1);
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Point p{place(random), place(random), place(random)};
    boxes.push_back(i % 7 == 3 ? Box{} : Box{p, p}.grown(i % 5 == 0 ? 0 : std::exp2(exponent(random))));
  }
  return boxes;
}

TEST(CellGrid, CellsOfBoxesAreThoseOfEach) {
  for (const auto& [size, cells] :
       {std::pair{Point{1, 1, 1}, 1000.0}, {Point{1, 0.3, 0.02}, 5000.0}, {Point{1, 1, 0}, 60.0}})
    for (const std::size_t count : {0, 1, 2, 5, 40}) {
      const CellGrid grid(Box{{0, 0, 0}, size}, cells);
      const std::vector<Box> boxes = random_boxes(count, static_cast<unsigned>(count));
      std::set<std::uint32_t> expected;
      for (const Box& box : boxes)
        grid.for_each_cell(box, [&](std::uint32_t cell) { expected.insert(cell); });
      EXPECT_EQ(grid.cells_of(boxes), std::vector<std::uint32_t>(expected.begin(), expected.end()));
    }
}

TEST(CellGrid, ManyBoxesAroundAllCellsAreNoWork) {
  const CellGrid grid(Box{{0, 0, 0}, {1, 1, 1}}, 1e9);
  const std::vector<Box> boxes(1000000, Box{{0.1, 0, 0}, {1, 1, 1}});  // one by one: 2 * 10^11 cells
  EXPECT_EQ(grid.cells_of(boxes).size(), grid.size() / 64 * 58);
}

}  // namespace
}  // namespace weft::partition::cell_grid_test
