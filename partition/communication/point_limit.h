// How many vertices a mesh that lies in slices can have.
#pragma once

#include <cstdint>
#include <string>

#include "meshing/base/error.h"

namespace weft::partition {

/// Slices number vertices in 32 bits, where the largest number stands for none.
inline constexpr std::uint64_t kMostPoints = 0xFFFFFFFE;

/// Why a mesh of so many vertices cannot lie in slices; empty: it can.
inline std::string too_many_points(std::uint64_t points) {
  return points <= kMostPoints
             ? ""
             : std::to_string(points) + " vertices exceed the limit of " + std::to_string(kMostPoints);
}

/// Throws meshing::InputError with that issue.
inline void refuse_too_many_points(std::uint64_t points) {
  if (const std::string issue = too_many_points(points); !issue.empty())
    throw meshing::InputError("", "", issue);
}

}  // namespace weft::partition
