// from_chars, and around it what other programs write all the same.
#include "meshing/io/files/text_numbers.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

#include "meshing/base/printable.h"

namespace weft::meshing {
namespace {

/// Reads what from_chars alone does not: Fortran's exponent letter D, and values beyond the range of double.
std::optional<double> parse_unusual_real(std::string_view word) {
  std::string copy(word);
  std::ranges::replace_if(
      copy, [](char c) { return c == 'd' || c == 'D' || c == 'E'; }, 'e');
  double value = 0;
  const auto [end, error] = std::from_chars(copy.data(), copy.data() + copy.size(), value);
  if (end != copy.data() + copy.size()) return std::nullopt;
  if (error == std::errc()) return value;
  if (error != std::errc::result_out_of_range) return std::nullopt;
  return copy.find("e-") == std::string::npos ? std::numeric_limits<double>::infinity() : 0.0;
}

}  // namespace

std::optional<std::int64_t> parse_integer(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::optional<double> parse_real(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc() && end == word.data() + word.size()) return value;
  return parse_unusual_real(word);
}

std::string quoted(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  if (word.empty()) return "the end of the file";
  const std::string text = printable(word.substr(0, kLongest));
  return "'" + text + (word.size() > kLongest ? "...'" : "'");
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace weft::meshing
