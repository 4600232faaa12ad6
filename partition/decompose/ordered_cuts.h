// Cuts ordered items that are spread over the ranks into parts of wanted weights, without sorting them across
// ranks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::partition {

/// This rank's items: entry i of each array is item i. Order: by key, equal keys by number.
struct OrderedItems {
  std::span<const std::uint64_t> keys;
  std::span<const std::uint64_t> numbers;  ///< different for each item of all ranks
  std::span<const std::uint64_t> weights;  ///< at least 1; all ranks' together below 2^62
};

/// Cuts each group of items into consecutive parts: part j of group g gets shares[g][j] of the sum of
/// shares[g], as nearly as whole items allow (each cut is at the item end nearest to where it should be).
/// `groups` names the group of each item, below shares.size(). Returns the part of each item; parts count on
/// through all groups. Independent of how the items are spread.
///
/// Every cut is narrowed down by weighted histograms over an interval of keys, then of numbers; a round
/// sends 32 KB at most, or 128 bytes a cut where that is more. Once few items are left, 1024 or 8 a cut, all
/// ranks get them: mostly after two to five rounds.
std::vector<std::uint32_t> cut_groups(Peers& peers, const OrderedItems& items,
                                      std::span<const std::uint32_t> groups,
                                      const std::vector<std::vector<std::uint32_t>>& shares);

/// A key that orders as the number does (infinities at the ends).
std::uint64_t ordered_key(double x);

/// Work as integers that add up to less than 2^62 over all ranks, whatever its spread: 1 and more, the
/// greatest work 2^61 / (number of items) or a little less. What is not a number counts as 0, as does
/// negative work; infinite work as the greatest finite number.
std::vector<std::uint64_t> integer_weights(Peers& peers, std::span<const double> work);

}  // namespace weft::partition
