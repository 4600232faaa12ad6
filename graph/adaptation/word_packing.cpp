// Differences in few bytes, four of them behind a byte of lengths.
#include "graph/adaptation/word_packing.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace weft::graph::adaptation {
namespace {

constexpr std::array<std::size_t, 4> kLengths = {0, 2, 3, 4};
// In words: single numbers, doubles and labels, triangles, tets, points, metrics.
constexpr std::array<std::uint8_t, 6> kLags = {1, 2, 3, 4, 6, 12};

std::uint32_t word_at(std::span<const std::byte> data, std::size_t i) {
  std::uint32_t word;
  std::memcpy(&word, data.data() + 4 * i, 4);
  return word;
}

/// Small differences of either sign become small numbers.
std::uint32_t folded(std::uint32_t difference) {
  const auto sign = static_cast<std::uint32_t>(static_cast<std::int32_t>(difference) >> 31);
  return difference << 1 ^ sign;
}
std::uint32_t unfolded(std::uint32_t code) { return code >> 1 ^ (0u - (code & 1)); }

unsigned length_index(std::uint32_t code) {
  if (code == 0) return 0;
  return code < 1u << 16 ? 1 : code < 1u << 24 ? 2 : 3;
}

/// By a sample.
std::uint8_t best_lag(std::span<const std::byte> data, std::size_t words) {
  constexpr std::size_t kSample = 2048;
  const std::size_t begin = words > 2 * kSample ? words / 2 : 12, end = std::min(words, begin + kSample);
  std::uint8_t best = kLags[0];
  std::size_t least = ~std::size_t{0};
  for (const std::uint8_t lag : kLags) {
    std::size_t bytes = 0;
    for (std::size_t i = begin; i < end; ++i)
      bytes += kLengths[length_index(folded(word_at(data, i) - word_at(data, i - lag)))];
    if (bytes < least) least = bytes, best = lag;
  }
  return best;
}

}  // namespace

void pack_words(std::span<const std::byte> data, std::vector<std::byte>& packed) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t words = data.size() / 4;
  const std::uint8_t lag = best_lag(data, words);
  const std::size_t before = packed.size();
  packed.resize(before + 1 + words * 4 + words / 4 + 1 + 3 + 4);  // at the most
  std::byte* to = packed.data() + before;
  *to++ = static_cast<std::byte>(lag);
  for (std::size_t i = 0; i < words; i += 4) {
    std::byte* const lengths = to++;
    unsigned control = 0;
    for (std::size_t k = 0; k < 4 && i + k < words; ++k) {
      const std::size_t at = i + k;
      const std::uint32_t code = folded(word_at(data, at) - (at >= lag ? word_at(data, at - lag) : 0));
      const unsigned index = length_index(code);
      control |= index << 2 * k;
      std::memcpy(to, &code, 4);
      to += kLengths[index];
    }
    *lengths = static_cast<std::byte>(control);
  }
  const std::size_t rest = data.size() - 4 * words;
  if (rest > 0) std::memcpy(to, data.data() + 4 * words, rest);
  packed.resize(static_cast<std::size_t>(to + rest - packed.data()));
}

std::span<const std::byte> unpack_words(std::span<const std::byte> packed, std::span<std::byte> data) {
  const auto take = [&](std::size_t size) {
    if (size > packed.size()) throw std::runtime_error("packed numbers end too soon");
    const auto part = packed.first(size);
    packed = packed.subspan(size);
    return part;
  };
  const std::size_t words = data.size() / 4;
  const auto lag = static_cast<std::size_t>(take(1)[0]);
  if (lag == 0) throw std::runtime_error("packed numbers have no lag");
  for (std::size_t i = 0; i < words; i += 4) {
    const auto control = static_cast<unsigned>(take(1)[0]);
    for (std::size_t k = 0; k < 4 && i + k < words; ++k) {
      const std::size_t at = i + k;
      std::uint32_t code = 0;
      const auto bytes = take(kLengths[control >> 2 * k & 3]);
      if (!bytes.empty()) std::memcpy(&code, bytes.data(), bytes.size());
      const std::uint32_t word = unfolded(code) + (at >= lag ? word_at(data, at - lag) : 0);
      std::memcpy(data.data() + 4 * at, &word, 4);
    }
  }
  const auto rest = take(data.size() - 4 * words);
  if (!rest.empty()) std::memcpy(data.data() + 4 * words, rest.data(), rest.size());
  return packed;
}

}  // namespace weft::graph::adaptation
