// From the highest byte to the lowest: a histogram of all ranks says in which 1/256 the value lies.
#include "partition/communication/select.h"

#include <bit>
#include <cstddef>
#include <vector>

namespace weft::partition {
namespace {

constexpr std::uint64_t kSign = std::uint64_t{1} << 63;

/// Unsigned numbers in the order of the doubles.
std::uint64_t key_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return bits & kSign ? ~bits : bits | kSign;
}
double value_of(std::uint64_t key) { return std::bit_cast<double>(key & kSign ? key & ~kSign : ~key); }

/// How many keys of all ranks have each value of the byte at `shift`.
std::vector<std::uint64_t> count_bytes(Peers& peers, const std::vector<std::uint64_t>& keys, int shift) {
  std::vector<std::uint64_t> counts(256), sums(256);
  for (const std::uint64_t key : keys) ++counts[key >> shift & 0xFF];
  for (const auto& of_rank : allgather(peers, counts))
    for (std::size_t b = 0; b < sums.size(); ++b) sums[b] += of_rank[b];
  return sums;
}

}  // namespace

double select(Peers& peers, std::span<const double> values, std::uint64_t place) {
  std::vector<std::uint64_t> keys;  // those that may still be it
  keys.reserve(values.size());
  for (const double value : values) keys.push_back(key_of(value));
  std::uint64_t found = 0;
  for (int shift = 56; shift >= 0; shift -= 8) {
    const std::vector<std::uint64_t> counts = count_bytes(peers, keys, shift);
    std::uint64_t byte = 0;
    for (; place >= counts[byte] && byte < 255; ++byte) place -= counts[byte];
    found |= byte << shift;
    std::erase_if(keys, [&](std::uint64_t key) { return (key >> shift & 0xFF) != byte; });
  }
  return value_of(found);
}

}  // namespace weft::partition
