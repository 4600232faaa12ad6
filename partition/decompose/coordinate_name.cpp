// A word, '=', and references with commas between them.
#include "partition/decompose/coordinate_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <stdexcept>

namespace weft::partition {
namespace {

constexpr std::string_view kHarmonic = "harmonic=", kWall = "wall=";

std::int32_t parse_reference(std::string_view text) {
  std::int32_t value = 0;
  const char* end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || read != end)
    throw std::invalid_argument(fmt::format("'{}' is not a reference of triangles", text));
  return value;
}

std::vector<std::int32_t> parse_references(std::string_view text) {
  std::vector<std::int32_t> refs;
  for (;;) {
    const std::size_t end = text.find(',');
    refs.push_back(parse_reference(text.substr(0, end)));
    if (end == std::string_view::npos) return refs;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

bool names_coordinate(std::string_view text) {
  return text.starts_with(kHarmonic) || text.starts_with(kWall);
}

BoundaryCoordinate parse_coordinate(std::string_view text) {
  if (text.starts_with(kWall))
    return {BoundaryCoordinate::Kind::wall, parse_references(text.substr(kWall.size()))};
  if (!text.starts_with(kHarmonic)) throw std::invalid_argument(fmt::format("'{}' is not known", text));
  BoundaryCoordinate c{BoundaryCoordinate::Kind::harmonic, parse_references(text.substr(kHarmonic.size()))};
  if (c.refs.size() != 2 || c.refs[0] == c.refs[1])
    throw std::invalid_argument(fmt::format("'{}' does not name two different references", text));
  return c;
}

std::string text_of(const BoundaryCoordinate& c) {
  if (!c.asked()) return "";
  return fmt::format("{}{}", c.kind == BoundaryCoordinate::Kind::wall ? kWall : kHarmonic,
                     fmt::join(c.refs, ","));
}

}  // namespace weft::partition
