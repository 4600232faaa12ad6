// Arrays of numbers in fewer bytes: what a mesh is made of differs little from one entry to the next.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace weft::graph::adaptation {

/// Appends `data` packed: each 32-bit word as its difference from the one `lag` words before (the lag that
/// suits the data best, of those that records of a mesh have), in 0, 2, 3 or 4 bytes. A quarter of a gigabyte
/// a second and more; indices and references shrink to a half and less, coordinates by a few per cent.
void pack_words(std::span<const std::byte> data, std::vector<std::byte>& packed);

/// A byte of what is packed stands for so many at the most.
inline constexpr std::size_t kMostUnpacked = 16;

/// The other way, into `data`, which has the size that was packed. Returns what of `packed` comes behind, or
/// throws std::runtime_error where it is not what pack_words has made.
std::span<const std::byte> unpack_words(std::span<const std::byte> packed, std::span<std::byte> data);

}  // namespace weft::graph::adaptation
