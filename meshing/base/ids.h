// Strong ids: a vertex id never passes for a tet id.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>

namespace weft::meshing {

/// A 32-bit index that converts to nothing silently. Default constructed it is invalid.
template <class Tag>
struct Id {
  static constexpr std::uint32_t kInvalidValue = 0xFFFFFFFFu;
  std::uint32_t value = kInvalidValue;

  constexpr Id() = default;
  constexpr explicit Id(std::uint32_t v) : value(v) {}
  constexpr bool valid() const { return value != kInvalidValue; }
  friend constexpr auto operator<=>(Id, Id) = default;
  friend std::ostream& operator<<(std::ostream& out, Id id) {
    return id.valid() ? out << Tag::kLetter << id.value : out << Tag::kLetter << '?';
  }
};

struct VertexTag {
  static constexpr char kLetter = 'v';
};
struct TetTag {
  static constexpr char kLetter = 't';
};
struct PatchTag {
  static constexpr char kLetter = 'p';
};
struct CurveTag {
  static constexpr char kLetter = 'c';
};

using VertexId = Id<VertexTag>;
using TetId = Id<TetTag>;
using PatchId = Id<PatchTag>;  ///< a smooth piece of boundary or material interface
using CurveId = Id<CurveTag>;  ///< a chain of feature edges between two corners

}  // namespace weft::meshing

template <class Tag>
struct std::hash<weft::meshing::Id<Tag>> {
  std::size_t operator()(weft::meshing::Id<Tag> id) const noexcept {
    return std::hash<std::uint32_t>{}(id.value);
  }
};
