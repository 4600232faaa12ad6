// Numbers as people read them: 1,234,567 tets, 1.2 GB, 83.0 %.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace weft::tools {

std::string grouped(std::uint64_t n);  ///< 1,234,567
std::string grouped(double x);         ///< rounded to an integer; from 1e15 on as 1.23e+17
/// "1 tet", "1,234 vertices": `one` is the word for a single one.
std::string counted(std::uint64_t n, const std::string& one);
std::string bytes_text(double bytes);                 ///< 1.2 GB (decimal units)
std::string seconds_text(double seconds);             ///< 0.12 s, 12.3 s, 2 min 05 s
std::string percent(double share, int decimals = 1);  ///< 0.83 -> 83.0 %

/// Changes needed to turn one word into the other: for "did you mean".
std::size_t edit_distance(const std::string& a, const std::string& b);

}  // namespace weft::tools
