// From the highest byte to the lowest: a histogram of all ranks says in which 1/256 the value lies.
#include "partition/communication/select.h"

#include <bit>
#include <cstddef>
#include <vector>

#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

constexpr std::uint64_t kSign = std::uint64_t{1} << 63;

/// Unsigned numbers in the order of the doubles.
std::uint64_t key_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return bits & kSign ? ~bits : bits | kSign;
}
double value_of(std::uint64_t key) { return std::bit_cast<double>(key & kSign ? key & ~kSign : ~key); }

/// The keys that may still be the one at `place`, and what is known of it.
struct Search {
  std::vector<std::uint64_t> keys;
  std::uint64_t place, found = 0;
};

/// How many keys of all ranks have each value of the byte at `shift`: 256 counts for each search.
std::vector<std::uint64_t> count_bytes(Peers& peers, const std::vector<Search>& searches, int shift) {
  std::vector<std::uint64_t> counts(256 * searches.size());
  for (std::size_t s = 0; s < searches.size(); ++s)
    for (const std::uint64_t key : searches[s].keys) ++counts[256 * s + (key >> shift & 0xFF)];
  return partition::sum(peers, counts);
}

void narrow(const std::uint64_t* counts, int shift, Search& search) {
  std::uint64_t byte = 0;
  for (; search.place >= counts[byte] && byte < 255; ++byte) search.place -= counts[byte];
  search.found |= byte << shift;
  std::erase_if(search.keys, [&](std::uint64_t key) { return (key >> shift & 0xFF) != byte; });
}

}  // namespace

std::vector<double> select(Peers& peers, std::span<const double> values,
                           std::span<const std::uint64_t> places) {
  std::vector<std::uint64_t> keys;
  keys.reserve(values.size());
  for (const double value : values) keys.push_back(key_of(value));
  std::vector<Search> searches;
  for (const std::uint64_t place : places) searches.push_back({keys, place});
  for (int shift = 56; shift >= 0; shift -= 8) {
    const std::vector<std::uint64_t> counts = count_bytes(peers, searches, shift);
    for (std::size_t s = 0; s < searches.size(); ++s) narrow(counts.data() + 256 * s, shift, searches[s]);
  }
  std::vector<double> found;
  for (const Search& search : searches) found.push_back(value_of(search.found));
  return found;
}

}  // namespace weft::partition
