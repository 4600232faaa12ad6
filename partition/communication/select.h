// The k-th smallest of values that many ranks have.
#pragma once

#include <cstdint>
#include <span>

#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks, with the same `place`: the value at index `place` of the values of all ranks in ascending
/// order. None is NaN; `place` is less than their number. Exact; eight exchanges of 2 KiB a rank.
double select(Peers& peers, std::span<const double> values, std::uint64_t place);

}  // namespace weft::partition
