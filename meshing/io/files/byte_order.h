// Numbers in files of either byte order.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace weft::meshing {

static_assert(std::endian::native == std::endian::little, "readers and writers swap big-endian data");

/// The bytes of a number in the other order.
template <class T>
T byte_swapped(T value) {
  static_assert(std::is_arithmetic_v<T>);
  if constexpr (sizeof(T) == 1) {
    return value;
  } else if constexpr (sizeof(T) == 2) {
    return std::bit_cast<T>(__builtin_bswap16(std::bit_cast<std::uint16_t>(value)));
  } else if constexpr (sizeof(T) == 4) {
    return std::bit_cast<T>(__builtin_bswap32(std::bit_cast<std::uint32_t>(value)));
  } else {
    return std::bit_cast<T>(__builtin_bswap64(std::bit_cast<std::uint64_t>(value)));
  }
}

/// The number that lies at `from`, which need not be aligned.
template <class T>
T load(const void* from, bool swapped) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return swapped ? byte_swapped(value) : value;
}

}  // namespace weft::meshing
