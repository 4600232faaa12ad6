// from_chars, and what strtod takes besides.
#include "tools/common/numbers.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <system_error>

namespace weft::tools {
namespace {

constexpr std::string_view kBlanks = " \t\n\v\f\r";

bool take(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

/// The number that the text begins with, which is taken from it.
std::optional<double> take_number(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const bool negative = take(text, "-");
  if (!negative) take(text, "+");
  const bool hexadecimal = take(text, "0x") || take(text, "0X");
  if (text.starts_with('-')) return std::nullopt;  // from_chars would take it
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value,
                      hexadecimal ? std::chars_format::hex : std::chars_format::general);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return negative ? -value : value;
}

/// The bytes of a unit.
std::optional<double> unit_of(std::string_view text) {
  std::string word;
  for (const char c : text)
    if (kBlanks.find(c) == std::string_view::npos)
      word += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  if (word.empty() || word == "B") return 1;
  const std::size_t power = std::string_view("KMGTPE").find(word.front());
  const std::string_view behind = std::string_view(word).substr(1);
  if (power == std::string_view::npos || !(behind.empty() || behind == "B" || behind == "IB"))
    return std::nullopt;
  return std::pow(1024.0, static_cast<double>(power + 1));
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  const std::optional<double> value = take_number(text);
  return text.empty() ? value : std::nullopt;
}

std::optional<double> parse_size(std::string_view text) {
  const std::optional<double> value = take_number(text);
  const std::optional<double> unit = unit_of(text);
  return value && unit ? std::optional(*value * *unit) : std::nullopt;
}

}  // namespace weft::tools
