// Heat in a square: explicit steps of the five-point stencil, zero outside.
#pragma once

#include <cstddef>

namespace weft::examples::heat {

constexpr double kCourant = 0.2;  ///< dt / h^2; at most 0.25 is stable

/// Rows of blocks are dealt out evenly: the first of a rank's; that of the last rank's successor is `rows`.
inline std::size_t first_row_of(int rank, int ranks, std::size_t rows) {
  const auto r = static_cast<std::size_t>(rank), n = static_cast<std::size_t>(ranks);
  return (rows * r + n - 1) / n;
}
inline int rank_of_row(std::size_t row, int ranks, std::size_t rows) {
  return static_cast<int>(row * static_cast<std::size_t>(ranks) / rows);
}

/// The temperature of a point at first.
inline double first_value(std::size_t row, std::size_t column) {
  return static_cast<double>((7 * row + 13 * column) % 101) / 100;
}

/// One step of `rows` x `columns` points. `now` and `next` are the first of them, rows are `stride` apart and
/// have a point of somebody else's around them.
inline void step(const double* now, double* next, std::size_t rows, std::size_t columns, std::size_t stride) {
  for (std::size_t r = 0; r < rows; ++r) {
    const double* here = now + r * stride;
    const double *above = here - stride, *below = here + stride;
    double* to = next + r * stride;
    for (std::size_t c = 0; c < columns; ++c)
      to[c] = here[c] + kCourant * (above[c] + below[c] + here[c - 1] + here[c + 1] - 4 * here[c]);
  }
}

}  // namespace weft::examples::heat
