// Patches of a surface in parts: connected sets of the parts' components.
#pragma once

#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::partition {

/// A connected set of a part's triangles, as its part sees it.
struct PatchComponent {
  std::uint64_t triangles, turned;  ///< how many; and how many are turned to agree with the first
  std::uint32_t first;              ///< the lowest number of a triangle
  std::int32_t ref;
  std::uint64_t one_sided = 0;  ///< 1: it does not agree with itself, as a Moebius strip
};

/// That two components, numbered over all parts, touch.
struct ComponentLink {
  std::uint32_t a, b;
  std::uint32_t turned;  ///< 1: they agree when all triangles of one of them are turned
  friend auto operator<=>(const ComponentLink&, const ComponentLink&) = default;
};

struct JoinedPatches {
  std::vector<std::uint32_t> patch;  ///< of each component of all parts
  std::vector<std::uint8_t>
      turned;  ///< components that are to be turned; of no meaning where there is one side
  // By patch:
  std::vector<std::int32_t> refs;
  std::vector<std::uint32_t> firsts;  ///< the lowest number of a triangle
  std::vector<std::uint8_t> one_sided;
};

/// Patches in the order of their first triangles, with the orientation that most of their triangles have as
/// they are. Components are numbered by ranks, then as given; the links may be known to either side or to
/// both. All ranks call together, and get the same.
JoinedPatches join_patches(Peers& peers, const std::vector<PatchComponent>& mine,
                           const std::vector<ComponentLink>& links);

}  // namespace weft::partition
