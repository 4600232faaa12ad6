// Messages put together from values.
#pragma once

#include <sstream>
#include <string>

namespace weft::engine {

/// A stream into a text that throws where an allocation fails: by itself it would only leave out the rest.
inline std::ostringstream text_stream() {
  std::ostringstream out;
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

}  // namespace weft::engine
