// Which rank makes which pieces of the surface.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/geometry/surface/cut_surface.h"

namespace weft::partition {

/// Things in order, named by pieces, which are dealt to the ranks.
class DealtPieces {
 public:
  DealtPieces() = default;  ///< of nothing
  /// `first`: the number of the first piece.
  DealtPieces(std::size_t things, std::uint32_t first, int ranks)
      : count_(meshing::pieces_of(things)), first_(first), ranks_(static_cast<std::uint64_t>(ranks)) {}

  /// The number that follows those of the pieces.
  std::uint32_t end() const { return first_ + count_; }
  std::uint32_t name(std::size_t place) const { return meshing::name_in_order(place, first_); }
  /// The rank that makes the piece of what has this name.
  std::size_t maker(std::uint32_t name) const {
    const std::uint64_t piece = meshing::piece_of_name(name) - first_;
    return static_cast<std::size_t>(((piece + 1) * ranks_ - 1) / count_);
  }
  /// What a rank makes, where it has all that is in its pieces: of things with these names.
  meshing::MadePieces made(int rank, std::span<const std::uint32_t> names) const {
    const auto r = static_cast<std::uint64_t>(rank);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> members;  // names first
    for (std::uint32_t i = 0; i < names.size(); ++i)
      if (names[i] != meshing::kNoName && maker(names[i]) == r) members.emplace_back(names[i], i);
    std::ranges::sort(members);
    meshing::MadePieces made;
    made.first = first_ + static_cast<std::uint32_t>(count_ * r / ranks_);
    for (const auto& [name, i] : members) made.members.push_back(i);
    return made;
  }

 private:
  std::uint32_t count_ = 0, first_ = 0;
  std::uint64_t ranks_ = 1;
};

}  // namespace weft::partition
