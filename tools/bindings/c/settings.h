// Structs that begin with their size: what a caller does not know is left out, what it knows too much of is
// refused.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "tools/bindings/c/calls.h"

namespace weft::c {

/// Copies the first `size` bytes, as many as the caller's struct has, over `known` bytes of ours.
void copy_sized(void* to, std::size_t known, const void* from, std::size_t size, const char* argument);

/// Fills as much of the caller's struct as it says to have and as there is; its size says how much then.
template <class Struct>
void fill_sized(Struct& to, const Struct& from, const char* argument) {
  const std::size_t size = to.size;
  require(size >= sizeof size && size <= 4096 && size % sizeof size == 0,
          std::string(argument) + ": set its member size to sizeof " + argument + " first");
  Struct filled = from;
  filled.size = std::min(size, sizeof filled);
  std::memcpy(&to, &filled, filled.size);
}

}  // namespace weft::c
