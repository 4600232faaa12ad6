// Names of the processes and of the objects that move between them.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>

namespace weft::engine {

/// One process of a run (an MPI rank), 0 to size - 1. Converts to nothing silently.
struct Rank {
  std::int32_t value = -1;

  constexpr Rank() = default;
  constexpr explicit Rank(std::int32_t v) : value(v) {}
  constexpr bool valid() const { return value >= 0; }
  constexpr std::size_t index() const { return static_cast<std::size_t>(value); }
  friend constexpr auto operator<=>(Rank, Rank) = default;
  friend std::ostream& operator<<(std::ostream& out, Rank rank) { return out << "rank " << rank.value; }
};

/// A mobile object's name for life: the rank that created it (its home) and that rank's running number.
/// Number 0 is no object but the rank's root, the function it was started with, which can send but not be
/// sent to.
struct ObjectId {
  Rank home;
  std::uint32_t number = 0;

  constexpr bool valid() const { return home.valid(); }
  constexpr bool is_root() const { return number == 0; }
  friend constexpr auto operator<=>(ObjectId, ObjectId) = default;
  /// Prints as 3.17: object 17 of rank 3.
  friend std::ostream& operator<<(std::ostream& out, ObjectId id) {
    return out << id.home.value << '.' << id.number;
  }
};

}  // namespace weft::engine

template <>
struct std::hash<weft::engine::ObjectId> {
  std::size_t operator()(weft::engine::ObjectId id) const noexcept {
    const auto key = static_cast<std::uint64_t>(static_cast<std::uint32_t>(id.home.value)) << 32 | id.number;
    return static_cast<std::size_t>((key ^ key >> 29) * 0x9E3779B97F4A7C15u);  // the halves alone cluster
  }
};
