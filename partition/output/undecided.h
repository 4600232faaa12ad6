// Entities of pieces that other pieces may have too: who counts them is decided at their homes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/parallel.h"
#include "partition/communication/home_rank.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// Flags of entities of one piece, of up to N vertices and of several kinds: one exchange serves them all.
template <std::size_t N>
class Undecided {
 public:
  /// `ids`: as all who have the entity name it. The lowest `subdomain` has it. `flag` stays where it is until
  /// decide().
  template <std::size_t Ids>
  void add(std::uint64_t kind, const EntityKey<Ids>& ids, std::uint64_t subdomain, std::uint8_t& flag) {
    static_assert(Ids <= N);
    EntityKey<N + 1> key{};
    key[0] = GlobalId::from_value(kind);
    std::ranges::copy(ids, key.begin() + 1);
    holdings_.push_back({key, subdomain});
    flags_.push_back(&flag);
  }

  /// All ranks: sets the flags of all pieces, to 1, or 0 where a lower subdomain has added the entity too.
  static void decide(Peers& peers, std::vector<Undecided> of_pieces) {
    std::vector<std::size_t> begins{0};
    std::vector<std::vector<Holding<N + 1>>> holdings;
    for (Undecided& piece : of_pieces) {
      begins.push_back(begins.back() + piece.flags_.size());
      holdings.push_back(std::move(piece.holdings_));
    }
    const std::vector<std::uint8_t> lowest = held_by_no_lower<N + 1>(peers, std::move(holdings));
    meshing::for_each_large(of_pieces.size(), [&](std::size_t p) {
      for (std::size_t i = 0; i < of_pieces[p].flags_.size(); ++i)
        *of_pieces[p].flags_[i] = lowest[begins[p] + i];
    });
  }

 private:
  std::vector<Holding<N + 1>> holdings_;
  std::vector<std::uint8_t*> flags_;
};

}  // namespace weft::partition
