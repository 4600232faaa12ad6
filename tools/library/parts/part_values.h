// Values at the points of parts become values at the points of slices.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "partition/communication/peers.h"
#include "tools/library/parts/part_numbers.h"

namespace weft::tools {

/// All ranks: numbers at the points with these ids, at the points of the slice, in the order of their ids, as
/// slice_of_parts() has them; of a point of several ranks that of the lowest. `issue`: of a point of this
/// slice for which ranks have different numbers, or empty.
std::vector<double> values_of_slice(partition::Peers& peers, const IdHomes& homes,
                                    const std::vector<std::uint64_t>& ids, std::span<const double> values,
                                    std::string& issue);

}  // namespace weft::tools
