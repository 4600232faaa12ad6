// Marks where numbers are dense; sorts where they are not.
#include "partition/slice/used_numbers.h"

#include <algorithm>
#include <limits>

#include "meshing/base/sort_unique.h"

namespace weft::partition {

std::vector<std::uint32_t> used_numbers(std::span<const meshing::Tet> tets) {
  std::uint32_t least = std::numeric_limits<std::uint32_t>::max(), largest = 0;
  for (const meshing::Tet& tet : tets)
    for (const std::uint32_t v : tet) {
      least = std::min(least, v);
      largest = std::max(largest, v);
    }
  std::vector<std::uint32_t> numbers;
  if (tets.empty()) return numbers;
  constexpr std::size_t kBitsOfCorners = 8 * sizeof(meshing::Tet);
  if (largest - least < kBitsOfCorners * tets.size()) {
    std::vector<bool> used(std::size_t{largest - least} + 1, false);
    for (const meshing::Tet& tet : tets)
      for (const std::uint32_t v : tet) used[v - least] = true;
    for (std::size_t i = 0; i < used.size(); ++i)
      if (used[i]) numbers.push_back(least + static_cast<std::uint32_t>(i));
    return numbers;
  }
  numbers.reserve(4 * tets.size());
  for (const meshing::Tet& tet : tets) numbers.insert(numbers.end(), tet.begin(), tet.end());
  meshing::sort_unique(numbers);
  return numbers;
}

}  // namespace weft::partition
