// The local decision of the colouring.
#include "partition/shift/colouring.h"

#include <algorithm>

namespace weft::partition {

bool receives(const Priority& mine, std::span<const Priority> neighbours) {
  return std::all_of(neighbours.begin(), neighbours.end(),
                     [&](const Priority& other) { return other < mine; });
}

}  // namespace weft::partition
