// Why an operator did or did not act: counted per operator, so that a stalled mesh can be explained.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace weft::meshing {

enum class Verdict : std::uint8_t {
  accepted,
  not_needed,             ///< the entity is fine as it is
  inverts,                ///< a tet would not be exactly POSITIVE
  worsens_quality,        ///< the worst tet would be worse
  too_long,               ///< an edge longer than allowed would appear
  too_short,              ///< an edge shorter than allowed would appear
  breaks_topology,        ///< the link condition fails or an entity would exist twice
  breaks_classification,  ///< a corner, ridge, patch or material interface would be lost
  leaves_surface,         ///< the boundary would deviate more than hausd, or fold
  required,               ///< a required entity would change
  frozen,                 ///< what lies outside this mesh might change, or a frozen vertex would
  conflict,               ///< another thread holds a vertex: rolled back, tried again later
  too_large,              ///< the cavity exceeds the kernel's limits
  count_
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(Verdict::count_)> kVerdictNames = {
    "accepted",       "not_needed", "inverts",         "worsens_quality",
    "too_long",       "too_short",  "breaks_topology", "breaks_classification",
    "leaves_surface", "required",   "frozen",          "conflict",
    "too_large"};

enum class Operator : std::uint8_t { collapse, split, swap_edge, swap_face, smooth, relocate, count_ };
inline constexpr std::array<std::string_view, static_cast<std::size_t>(Operator::count_)> kOperatorNames = {
    "collapse", "split", "swap_edge", "swap_face", "smooth", "relocate"};

/// How often each operator came to each verdict.
struct OperationCounts {
  std::array<std::array<std::uint64_t, static_cast<std::size_t>(Verdict::count_)>,
             static_cast<std::size_t>(Operator::count_)>
      of{};
  void add(Operator op, Verdict v) { ++of[static_cast<std::size_t>(op)][static_cast<std::size_t>(v)]; }
  std::uint64_t operator()(Operator op, Verdict v) const {
    return of[static_cast<std::size_t>(op)][static_cast<std::size_t>(v)];
  }
  OperationCounts& operator+=(const OperationCounts& o) {
    for (std::size_t i = 0; i < of.size(); ++i)
      for (std::size_t j = 0; j < of[i].size(); ++j) of[i][j] += o.of[i][j];
    return *this;
  }
};

}  // namespace weft::meshing
