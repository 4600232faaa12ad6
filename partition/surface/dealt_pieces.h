// Which rank makes which pieces of the surface.
#pragma once

#include <cstddef>
#include <cstdint>

#include "meshing/geometry/surface/cut_surface.h"

namespace weft::partition {

/// Things in order, dealt to the ranks in pieces.
class DealtPieces {
 public:
  DealtPieces(std::size_t things, int ranks)
      : pieces_(meshing::pieces_of(things)), ranks_(static_cast<std::uint64_t>(ranks)) {}
  std::uint32_t count() const { return pieces_; }
  std::uint32_t first(int rank) const {
    return static_cast<std::uint32_t>(pieces_ * static_cast<std::uint64_t>(rank) / ranks_);
  }
  std::size_t maker(std::uint64_t place) const {
    const std::uint64_t piece = place / meshing::kSurfacePieceSize;
    return static_cast<std::size_t>(((piece + 1) * ranks_ - 1) / pieces_);
  }

 private:
  std::uint32_t pieces_;
  std::uint64_t ranks_;
};

}  // namespace weft::partition
