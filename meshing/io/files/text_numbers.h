// Words of text files as numbers, faster than streams and stricter than strtod.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace weft::meshing {

inline bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

std::optional<std::int64_t> parse_integer(std::string_view word);

/// Also Fortran's exponent letter D; values beyond the range of double become infinite or zero.
std::optional<double> parse_real(std::string_view word);

/// A word of a file for a message: quoted and not too long, or "the end of the file" for an empty one.
std::string quoted(std::string_view word);

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

}  // namespace weft::meshing
