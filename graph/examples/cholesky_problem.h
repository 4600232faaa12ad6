// A symmetric positive definite matrix in tiles, the four kernels of its Cholesky factor, and which rank has
// which tile. Tiles are columns first.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

namespace weft::examples::cholesky {

using Tile = Eigen::Map<Eigen::MatrixXd>;
using ConstTile = Eigen::Map<const Eigen::MatrixXd>;

inline double element(int row, int column) {
  return 1.0 / (1 + std::abs(row - column)) + (row == column ? 1 : 0);
}

inline std::vector<double> first_values(int row, int column, int tile) {
  std::vector<double> values(static_cast<std::size_t>(tile) * static_cast<std::size_t>(tile));
  Tile view(values.data(), tile, tile);
  for (int c = 0; c < tile; ++c)
    for (int r = 0; r < tile; ++r) view(r, c) = element(row * tile + r, column * tile + c);
  return values;
}

/// A tile of the diagonal becomes its factor L; what is above the diagonal is set to 0.
inline void factor(Tile diagonal) {
  Eigen::Ref<Eigen::MatrixXd> view(diagonal);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> in_place(view);
  diagonal.triangularView<Eigen::StrictlyUpper>().setZero();
}
/// X L^T = tile is solved for X.
inline void solve(Tile tile, const ConstTile& factor) {
  factor.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(tile);
}
/// tile -= left right^T; of a tile of the diagonal, where both are the same, the lower half.
inline void update(Tile tile, const ConstTile& left, const ConstTile& right) {
  if (left.data() == right.data()) {
    tile.selfadjointView<Eigen::Lower>().rankUpdate(left, -1);
  } else {
    tile.noalias() -= left * right.transpose();
  }
}

/// Tiles of the lower half, dealt out to ranks in both directions.
struct Layout {
  int tiles = 0;              ///< a side
  int rows = 1, columns = 1;  ///< of ranks

  Layout(int tiles_, int ranks) : tiles(tiles_), rows(static_cast<int>(std::sqrt(ranks))) {
    while (ranks % rows != 0) --rows;
    columns = ranks / rows;
    numbers_.resize(place(tiles, tiles));
    for (int rank = 0; rank < ranks; ++rank) {
      std::uint32_t number = 0;
      for_tiles_of(rank, [&](int r, int c) { numbers_[place(r, c)] = number++; });
    }
  }
  int rank_of(int row, int column) const { return row % rows * columns + column % columns; }

  /// Column by column.
  template <class Call>
  void for_tiles_of(int rank, const Call& call) const {
    for (int column = 0; column < tiles; ++column)
      for (int row = column; row < tiles; ++row)
        if (rank_of(row, column) == rank) call(row, column);
  }

  /// Calls `call(row, column)` for the tiles that factor (row, column) changes: those of its row right of it,
  /// those of the column that has its row's number, and below a tile of the diagonal its own column.
  template <class Call>
  void for_users_of(int row, int column, const Call& call) const {
    if (row == column) {
      for (int r = row + 1; r < tiles; ++r) call(r, column);
      return;
    }
    for (int c = column + 1; c <= row; ++c) call(row, c);
    for (int r = row + 1; r < tiles; ++r) call(r, row);
  }
  std::set<int> ranks_that_use(int row, int column) const {
    std::set<int> ranks;
    for_users_of(row, column, [&](int r, int c) { ranks.insert(rank_of(r, c)); });
    return ranks;
  }
  /// Of a tile, where the lower half is stored column by column of tiles.
  std::size_t place(int row, int column) const {
    return static_cast<std::size_t>(column * tiles - column * (column - 1) / 2 + row - column);
  }
  /// Of a tile among those of its rank, column by column.
  std::uint32_t number(int row, int column) const { return numbers_[place(row, column)]; }

 private:
  std::vector<std::uint32_t> numbers_;
};

}  // namespace weft::examples::cholesky
