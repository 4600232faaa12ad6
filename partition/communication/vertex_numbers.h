// The vertices that tets name, each once, and where each is among them. Tets of a mesh in good order name
// again what others named just before: what was met last is looked up first.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"

namespace weft::partition {

/// A table of what was met last, by the lowest bits of the number.
template <class Entry>
class RecentNumbers {
 public:
  Entry& at(std::uint32_t number) { return entries_[number % kSize]; }

 private:
  static constexpr std::size_t kSize = 1 << 12;
  std::vector<Entry> entries_ = std::vector<Entry>(kSize);
};

/// Each vertex of the tets once, ascending; vertices(tet) is an array of four.
template <class Tet, class Vertices>
std::vector<std::uint32_t> distinct_vertices(std::span<const Tet> tets, const Vertices& vertices) {
  struct Met {
    std::uint64_t number = std::numeric_limits<std::uint64_t>::max();
  };
  RecentNumbers<Met> recent;
  std::vector<std::uint32_t> numbers;
  for (const Tet& tet : tets)
    for (const std::uint32_t v : vertices(tet)) {
      Met& met = recent.at(v);
      if (met.number == v) continue;
      met.number = v;
      numbers.push_back(v);
    }
  meshing::sort_unique(numbers);
  return numbers;
}

/// Places of numbers in an ascending list that has them.
class PlacesOfNumbers {
 public:
  explicit PlacesOfNumbers(std::span<const std::uint32_t> numbers) : numbers_(numbers) {}

  std::uint32_t operator()(std::uint32_t number) {
    Known& known = recent_.at(number);
    if (known.number != number)
      known = {number, static_cast<std::uint32_t>(meshing::place_in(numbers_, number))};
    return known.place;
  }
  std::array<std::uint32_t, 4> operator()(const std::array<std::uint32_t, 4>& tet) {
    return {(*this)(tet[0]), (*this)(tet[1]), (*this)(tet[2]), (*this)(tet[3])};
  }

 private:
  struct Known {
    std::uint64_t number = std::numeric_limits<std::uint64_t>::max();
    std::uint32_t place = 0;
  };
  std::span<const std::uint32_t> numbers_;
  RecentNumbers<Known> recent_;
};

/// Tets by the places of their vertices among `numbers`.
struct PlacedTets {
  std::vector<std::uint32_t> numbers;  ///< of the vertices, ascending
  std::vector<std::array<std::uint32_t, 4>> tets;
};

inline PlacedTets placed(std::span<const std::array<std::uint32_t, 4>> tets) {
  PlacedTets result{distinct_vertices(tets, [](const auto& tet) { return tet; }), {}};
  PlacesOfNumbers places(result.numbers);
  result.tets.reserve(tets.size());
  for (const auto& tet : tets) result.tets.push_back(places(tet));
  return result;
}

}  // namespace weft::partition
