// A set of pieces.
#include "meshing/geometry/surface_piece.h"

#include <algorithm>

namespace weft::meshing {

std::size_t SurfacePiece::bytes() const {
  const auto of = [](const auto& list) { return list.size() * sizeof(list[0]); };
  return sizeof *this + of(triangles) + of(parameters) + of(features) + of(corners) + of(triangle_list) +
         of(feature_list);
}

void SurfacePieces::add(std::span<const Piece> pieces) {
  for (const Piece& piece : pieces) {
    const std::uint32_t row = piece->id >> kRowBits;
    if (row >= row_of_.size()) row_of_.resize(row + 1, kNoName);
    if (row_of_[row] == kNoName) {
      row_of_[row] = static_cast<std::uint32_t>(rows_.size());
      rows_.push_back({});
    }
    const SurfacePiece*& place = rows_[row_of_[row]][piece->id & kRowMask];
    if (place) continue;
    place = piece.get();
    pieces_.push_back(piece);
  }
  std::ranges::sort(pieces_, {}, [](const Piece& piece) { return piece->id; });
}

}  // namespace weft::meshing
