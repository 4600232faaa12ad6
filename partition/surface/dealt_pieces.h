// Which rank makes which pieces of the surface.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/geometry/surface/cut_surface.h"
#include "partition/communication/even_shares.h"

namespace weft::partition {

/// Things in order, named by pieces, which are dealt to the ranks.
class DealtPieces {
 public:
  DealtPieces() = default;  ///< of nothing
  /// `first`: the number of the first piece.
  DealtPieces(std::size_t things, std::uint32_t first, int ranks)
      : count_(meshing::pieces_of(things)), first_(first), shares_(count_, ranks) {}

  /// The number that follows those of the pieces.
  std::uint32_t end() const { return first_ + count_; }
  std::uint32_t name(std::size_t place) const { return meshing::name_in_order(place, first_); }
  /// The rank that makes the piece of what has this name.
  std::size_t maker(std::uint32_t name) const {
    return shares_.rank_of(meshing::piece_of_name(name) - first_);
  }
  /// What a rank makes, where it has all that is in its pieces: of things with these names.
  meshing::MadePieces made(int rank, std::span<const std::uint32_t> names) const {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> members;  // names first
    for (std::uint32_t i = 0; i < names.size(); ++i)
      if (names[i] != meshing::kNoName && maker(names[i]) == static_cast<std::size_t>(rank))
        members.emplace_back(names[i], i);
    std::ranges::sort(members);
    meshing::MadePieces made;
    made.first = first_ + static_cast<std::uint32_t>(shares_.first(rank));
    for (const auto& [name, i] : members) made.members.push_back(i);
    return made;
  }

 private:
  std::uint32_t count_ = 0, first_ = 0;
  EvenShares shares_{0, 1};
};

}  // namespace weft::partition
