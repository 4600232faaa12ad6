#include "tools/report/encode/base64.h"

#include <bit>

namespace weft::report {

static_assert(std::endian::native == std::endian::little);

std::string base64(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    std::uint32_t word = std::to_integer<std::uint32_t>(bytes[i]) << 16;
    if (left > 1) word |= std::to_integer<std::uint32_t>(bytes[i + 1]) << 8;
    if (left > 2) word |= std::to_integer<std::uint32_t>(bytes[i + 2]);
    text += kDigits[word >> 18];
    text += kDigits[word >> 12 & 63];
    text += left > 1 ? kDigits[word >> 6 & 63] : '=';
    text += left > 2 ? kDigits[word & 63] : '=';
  }
  return text;
}

}  // namespace weft::report
