// The k-th smallest of values that many ranks have.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks, with the same `places`: the values at these indices of the values of all ranks in ascending
/// order. None is NaN; each place is less than their number. Exact; at most eight sums of 2 KiB a place.
std::vector<double> select(Peers& peers, std::span<const double> values,
                           std::span<const std::uint64_t> places);

/// What is wanted of values that are in several lists.
struct Selection {
  std::vector<std::span<const double>> lists;
  std::span<const std::uint64_t> places;
};
/// Of several at once, in as many exchanges as of one.
std::vector<std::vector<double>> select_each(Peers& peers, std::span<const Selection> selections);

}  // namespace weft::partition
