// Where numbers stand in a long sorted list that is asked often.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/assert.h"

namespace weft::meshing {

/// place_in() in constant time where numbers lie evenly or in dense runs: their range is cut into one or two
/// stretches a number, and only the numbers of one are searched. Memory: 4 to 8 bytes a number.
class PlaceIndex {
 public:
  /// Each number once; fewer than 2^32. They must outlive the object.
  explicit PlaceIndex(std::span<const std::uint32_t> ascending) : numbers_(ascending) {
    if (numbers_.empty()) return;
    const std::uint32_t range = numbers_.back() - numbers_.front();
    while ((range >> shift_) > 2 * numbers_.size()) ++shift_;
    firsts_.resize(std::size_t{range >> shift_} + 2);
    std::uint32_t place = 0;
    for (std::size_t s = 0; s < firsts_.size(); ++s) {
      while (place < numbers_.size() && stretch_of(numbers_[place]) < s) ++place;
      firsts_[s] = place;
    }
  }

  /// Of a number that the list has.
  std::uint32_t operator()(std::uint32_t number) const {
    const std::size_t stretch = stretch_of(number);
    const auto first = numbers_.begin() + firsts_[stretch], last = numbers_.begin() + firsts_[stretch + 1];
    const auto at = std::lower_bound(first, last, number);
    WEFT_ASSERT_LIGHT(at != last && *at == number, "the list has the number");
    return static_cast<std::uint32_t>(at - numbers_.begin());
  }

 private:
  std::size_t stretch_of(std::uint32_t number) const { return (number - numbers_.front()) >> shift_; }

  std::span<const std::uint32_t> numbers_;
  int shift_ = 0;
  std::vector<std::uint32_t> firsts_;  ///< of each stretch; ends with their number
};

}  // namespace weft::meshing
