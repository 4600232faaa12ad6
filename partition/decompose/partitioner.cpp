// Reads the name of a partitioner.
#include "partition/decompose/partitioner.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace weft::partition {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& reason) {
  throw std::invalid_argument(fmt::format(
      "partitioner '{}': {} (allowed: bisection, graph, pqr, pqr:PxQxR with three numbers from 1, "
      "each pqr also with :harmonic=A,B or :wall=A,..., with references of triangles, "
      "then :principal, then :fewer)",
      text, reason));
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::array<std::uint32_t, 3> parse_slabs(const std::string& text, std::string_view slabs) {
  const auto parts = split(slabs, 'x');
  if (parts.size() != 3) refuse(text, fmt::format("'{}' is not of the form PxQxR", slabs));
  std::array<std::uint32_t, 3> numbers{};
  std::uint64_t product = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const char* end = parts[i].data() + parts[i].size();
    const auto [read, error] = std::from_chars(parts[i].data(), end, numbers[i]);
    if (error != std::errc{} || read != end || numbers[i] == 0)
      refuse(text, fmt::format("'{}' is not a number of slabs", parts[i]));
    product *= numbers[i];
    if (product > std::numeric_limits<std::uint32_t>::max()) refuse(text, "has too many subdomains");
  }
  return numbers;
}

BoundaryCoordinate parse_coordinate_of(const std::string& text, std::string_view option) {
  try {
    return parse_coordinate(option);
  } catch (const std::invalid_argument& error) {
    refuse(text, error.what());
  }
}

Partitioner parse_pqr(const std::string& text, std::vector<std::string_view> options) {
  Partitioner p{Partitioner::Kind::pqr, {}, false, false, {}, false};
  const auto take = [&](std::string_view name) {
    const bool given = !options.empty() && options.back() == name;
    if (given) options.pop_back();
    return given;
  };
  p.fewer = take("fewer");
  p.principal_axes = take("principal");
  if (!options.empty() && names_coordinate(options.back())) {
    p.coordinate = parse_coordinate_of(text, options.back());
    options.pop_back();
  }
  if (options.size() > 1) refuse(text, fmt::format("'{}' is not known", options.back()));
  if (options.size() == 1) p.slabs = parse_slabs(text, options[0]);
  return p;
}

}  // namespace

Partitioner parse_partitioner(const std::string& text, std::uint32_t num_subdomains) {
  std::vector<std::string_view> parts = split(text, ':');
  const std::string_view name = parts[0];
  parts.erase(parts.begin());
  if (name == "pqr") {
    Partitioner p = parse_pqr(text, parts);
    const std::uint32_t product = p.slabs[0] * p.slabs[1] * p.slabs[2];
    if (product != 0 && num_subdomains != 0 && product != num_subdomains)
      refuse(text, fmt::format("{}x{}x{} makes {} subdomains, not {}", p.slabs[0], p.slabs[1], p.slabs[2],
                               product, num_subdomains));
    return p;
  }
  if (name != "bisection" && name != "graph") refuse(text, fmt::format("'{}' is not known", name));
  if (!parts.empty()) refuse(text, fmt::format("{} takes no options", name));
  return {
      name == "graph" ? Partitioner::Kind::graph : Partitioner::Kind::bisection, {}, false, false, {}, false};
}

}  // namespace weft::partition
