// Recursive bisection. Tets of a block keep their numbers, new ones come behind all: so blocks go back side
// by side, and links between frozen tets of different blocks are right all the time.
#include "meshing/initial/grid/grid_block.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "meshing/base/box.h"

namespace weft::meshing {
namespace {

class Division {
 public:
  Division(const TetGrid& grid, std::size_t count)
      : grid_(grid), block_(grid.tets.size(), kNothing), blocks_(count) {}

  std::vector<GridBlock> run() {
    std::vector<Middle> middles;
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t)
      if (grid_.alive(t)) middles.push_back({middle(t), t});
    bisect(middles, 0, blocks_.size());
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) { extract(b); });
    return std::move(blocks_);
  }

 private:
  struct Middle {
    Point at;
    std::uint32_t tet;
  };

  Point middle(std::uint32_t t) const {
    const Tet4& v = grid_.tets[t].v;
    const auto& p = grid_.points;
    return 0.25 * (p[v[0]] + p[v[1]] + p[v[2]] + p[v[3]]);
  }

  void bisect(std::span<Middle> part, std::size_t first, std::size_t last) {
    if (last - first == 1) return list(part, first);
    Box box;
    for (const Middle& m : part) box.include(m.at);
    const Vec size = box.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t half = first + (last - first) / 2;
    const std::size_t left = part.size() * (half - first) / (last - first);
    std::ranges::nth_element(part, part.begin() + static_cast<std::ptrdiff_t>(left), {},
                             [axis](const Middle& m) { return std::pair(m.at[axis], m.tet); });
    tbb::parallel_invoke([&] { bisect(part.first(left), first, half); },
                         [&] { bisect(part.subspan(left), half, last); });
  }

  void list(std::span<const Middle> part, std::size_t number) {
    for (const Middle& m : part) {
      block_[m.tet] = static_cast<std::uint32_t>(number);
      blocks_[number].tets.push_back(m.tet);
    }
    std::ranges::sort(blocks_[number].tets);
  }

  void extract(std::size_t number) {
    GridBlock& block = blocks_[number];
    const auto borders = [&](std::uint32_t t) {
      return std::ranges::any_of(grid_.tets[t].n,
                                 [&](std::uint32_t n) { return n != kNothing && block_[n >> 2] != number; });
    };
    const auto inner = std::ranges::stable_partition(block.tets, borders);
    block.frozen = static_cast<std::uint32_t>(inner.begin() - block.tets.begin());
    std::vector<std::uint32_t> vertex(grid_.points.size(), kNothing), tet(grid_.tets.size(), kNothing);
    for (std::uint32_t i = 0; i < block.tets.size(); ++i) tet[block.tets[i]] = i;
    for (std::uint32_t i = 0; i < block.tets.size(); ++i) {
      TetGrid::Tet copy = grid_.tets[block.tets[i]];
      for (std::uint32_t& v : copy.v) {
        if (vertex[v] == kNothing) vertex[v] = add_vertex(block, v);
        v = vertex[v];
        block.grid.vertex_tet[v] = i;
      }
      for (std::uint32_t& n : copy.n)
        if (n != kNothing) n = tet[n >> 2] == kNothing ? kNothing : 4 * tet[n >> 2] + (n & 3);
      block.grid.tets.push_back(copy);
    }
  }

  std::uint32_t add_vertex(GridBlock& block, std::uint32_t v) const {
    block.vertices.push_back(v);
    return block.grid.add_point(grid_.points[v]);
  }

  const TetGrid& grid_;
  std::vector<std::uint32_t> block_;
  std::vector<GridBlock> blocks_;
};

/// Numbers of the points and tets that a block has made follow those of the blocks before it.
std::vector<JoinedNumbers> number(TetGrid& grid, std::span<const GridBlock> blocks) {
  const auto extended = [](std::vector<std::uint32_t> numbers, std::size_t size, std::size_t& end) {
    while (numbers.size() < size) numbers.push_back(static_cast<std::uint32_t>(end++));
    return numbers;
  };
  std::size_t points = grid.points.size(), tets = grid.tets.size();
  std::vector<JoinedNumbers> numbers;
  for (const GridBlock& b : blocks)
    numbers.push_back(
        {extended(b.vertices, b.grid.points.size(), points), extended(b.tets, b.grid.tets.size(), tets)});
  grid.points.resize(points);
  grid.vertex_tet.resize(points, kNothing);
  grid.tets.resize(tets);
  return numbers;
}

void put_back(TetGrid& grid, const GridBlock& block, const JoinedNumbers& numbers) {
  for (std::size_t v = block.vertices.size(); v < numbers.points.size(); ++v)
    grid.points[numbers.points[v]] = block.grid.points[v];
  for (std::uint32_t i = 0; i < numbers.tets.size(); ++i) {
    const TetGrid::Tet& from = block.grid.tets[i];
    TetGrid::Tet& to = grid.tets[numbers.tets[i]];
    for (std::size_t k = 0; k < 4; ++k) {
      to.v[k] = block.grid.alive(i) ? numbers.points[from.v[k]] : 0;
      if (from.n[k] != kNothing)
        to.n[k] = 4 * numbers.tets[from.n[k] >> 2] + (from.n[k] & 3);
      else if (i >= block.frozen)
        to.n[k] = kNothing;
      to.facet[k] = from.facet[k];
    }
  }
}

}  // namespace

std::vector<GridBlock> divide(const TetGrid& grid, std::size_t count) { return Division(grid, count).run(); }

std::vector<JoinedNumbers> join(TetGrid& grid, std::span<const GridBlock> blocks) {
  const std::vector<JoinedNumbers> numbers = number(grid, blocks);
  tbb::parallel_for(std::size_t{0}, blocks.size(),
                    [&](std::size_t b) { put_back(grid, blocks[b], numbers[b]); });
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (std::uint32_t i = 0; i < numbers[b].tets.size(); ++i)
      if (blocks[b].grid.alive(i))
        for (const std::uint32_t v : grid.tets[numbers[b].tets[i]].v) grid.vertex_tet[v] = numbers[b].tets[i];
      else
        grid.remove(numbers[b].tets[i]);
  return numbers;
}

}  // namespace weft::meshing
