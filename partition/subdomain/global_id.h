// Names of subdomains and of vertices that are valid everywhere.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>

#include "meshing/base/ids.h"

namespace weft::partition {

struct SubdomainTag {
  static constexpr char kLetter = 's';
};
/// Number of a subdomain, 0 to N - 1, the same everywhere.
using SubdomainId = meshing::Id<SubdomainTag>;

/// A vertex's name for life, wherever its copies are (the paper's pair of subdomain and local number). Those
/// of the input carry their number in it; new vertices count on from there in the subdomain that creates
/// them. Identity is by this name only, never by coordinates. Plain data.
class GlobalId {
 public:
  static constexpr int kLocalBits = 40;

  constexpr GlobalId() = default;
  constexpr GlobalId(SubdomainId owner, std::uint64_t local)
      : value_((std::uint64_t{owner.value} + 1) << kLocalBits | local) {}
  static constexpr GlobalId from_value(std::uint64_t value) {
    GlobalId id;
    id.value_ = value;
    return id;
  }

  /// A name made from two others (refine_interface.h): a hash, apart from all names that count.
  static constexpr GlobalId derived_from(GlobalId a, GlobalId b) {
    return from_value(mix(mix(a.value_ + 0x9E3779B97F4A7C15ull) + b.value_) | kDerived);
  }
  constexpr bool derived() const { return value_ & kDerived; }

  constexpr bool valid() const { return value_ != 0; }
  constexpr SubdomainId owner() const {
    return SubdomainId(static_cast<std::uint32_t>((value_ >> kLocalBits) - 1));
  }
  constexpr std::uint64_t local() const { return value_ & ((std::uint64_t{1} << kLocalBits) - 1); }
  constexpr std::uint64_t value() const { return value_; }  ///< 0 for none

  friend constexpr auto operator<=>(GlobalId, GlobalId) = default;
  friend std::ostream& operator<<(std::ostream& out, GlobalId id) {
    return id.valid() ? out << id.owner().value << ':' << id.local() : out << "none";
  }

 private:
  static constexpr std::uint64_t kDerived = std::uint64_t{1} << 63;

  /// A bijection of 64 bits that leaves no pattern.
  static constexpr std::uint64_t mix(std::uint64_t x) {
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ x >> 27) * 0x94D049BB133111EBull;
    return x ^ x >> 31;
  }

  std::uint64_t value_ = 0;
};

}  // namespace weft::partition

template <>
struct std::hash<weft::partition::GlobalId> {
  std::size_t operator()(weft::partition::GlobalId id) const noexcept {
    std::uint64_t x = id.value() * 0x9E3779B97F4A7C15ull;  // low bits alone are nearly consecutive
    return x ^ x >> 32;
  }
};
