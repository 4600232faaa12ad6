// Words as numbers, whatever the program's locale.
#pragma once

#include <optional>
#include <string_view>

namespace weft::tools {

/// What strtod reads in the "C" locale, blanks and a plus before it and hexadecimal included, and nothing
/// else; empty where it is no number, or one that a double cannot have.
std::optional<double> parse_number(std::string_view text);

/// A number of bytes, which may have a unit: K, M, G, T, P or E, of powers of 1024, with B or iB behind it or
/// not, in small letters too: 8G.
std::optional<double> parse_size(std::string_view text);

}  // namespace weft::tools
