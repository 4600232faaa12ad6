// Where a value stands in a sorted list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace weft::meshing {

/// The place of a value in an ascending list that has it; of several equal ones that of the first.
template <class List, class Value, class Projection = std::identity>
std::size_t place_in(const List& ascending, const Value& value, Projection projection = {}) {
  return static_cast<std::size_t>(std::ranges::lower_bound(ascending, value, {}, projection) -
                                  std::ranges::begin(ascending));
}

}  // namespace weft::meshing
