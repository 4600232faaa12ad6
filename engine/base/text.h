// Messages put together from values.
#pragma once

#include <array>
#include <charconv>
#include <locale>
#include <sstream>
#include <string>

namespace weft::engine {

/// A stream into a text that throws where an allocation fails: by itself it would only leave out the rest.
/// Numbers are written alike whatever the program's locale.
inline std::ostringstream text_stream() {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.exceptions(std::ios::badbit);
  return out;
}

/// The values one after the other, as << prints them.
template <class... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out = text_stream();
  (out << ... << parts);
  return out.str();
}

/// As printf's %.Ng writes it in the "C" locale, whatever the program's is.
inline std::string significant(double value, int digits) {
  std::array<char, 64> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits);
  return {text.data(), end};
}

}  // namespace weft::engine
