// Messages put together from values.
#pragma once

#include <sstream>
#include <string>

namespace weft::engine {

/// The values one after the other, as << prints them.
template <class... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

}  // namespace weft::engine
