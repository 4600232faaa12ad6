// Tells when slabs would be mostly interface, and how many are worthwhile.
#pragma once

#include <cstdint>
#include <span>

#include "partition/communication/peers.h"
#include "partition/decompose/slabs.h"
#include "partition/decompose/weighted_items.h"

namespace weft::partition {

/// `slabs`: as many slabs of these bricks, evenly along each axis, that their interfaces are expected to have
/// at most kMostShared of all vertices, but no fewer than fewest_slabs along an axis that has more. What is
/// near an interface is adapted twice, and a slab thinner than the layers that a shift hands over is all
/// interface: as soon as it had been adapted it would give everything to a neighbour, which would adapt it
/// again.
///
/// `complexities`: of the metric in each item; all 0: nothing is known, and all slabs are left. All ranks
/// call together; the result does not depend on how the items are spread.
struct WorthwhileSlabs {
  Slabs slabs;
  double share_asked = 0;  ///< of all vertices in the interfaces of the bricks as they are; 0: not known
  double share_left = 0;   ///< in those of `slabs`: more than kMostShared where fewest_slabs is the limit
  double share_cubes =
      0;  ///< in those of as many subdomains that are cubes in the metric, as a graph's nearly are
};
WorthwhileSlabs worthwhile_slabs(Peers& peers, const ItemFaces& faces, std::span<const double> complexities,
                                 const Bricks& bricks);

/// Of a million vertices that leaves 12 or 13 slabs. With 18 or 20 all is within layers of an interface, with
/// 8 or 9 the ranks wait for each other.
constexpr double kMostShared = 0.1;

/// Along an axis: half as many again as of cubes of this number of subdomains, but 8 at least. What is left
/// out is thin by its shape; small bricks that are nearly cubes are small because that is what was asked for.
std::uint32_t fewest_slabs(std::uint64_t num_subdomains);

}  // namespace weft::partition
