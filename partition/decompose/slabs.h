// The geometric partitioners: PQR and recursive inertial bisection.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "meshing/base/point.h"
#include "partition/communication/peers.h"
#include "partition/decompose/weighted_items.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// P, Q, R.
using Slabs = std::array<std::uint32_t, 3>;

inline std::uint64_t num_bricks(const Slabs& slabs) { return std::uint64_t{slabs[0]} * slabs[1] * slabs[2]; }

/// What slabs are cut across; alike on all ranks.
struct SlabDirections {
  bool principal_axes = false;  ///< those of the work, not x, y, z
  bool coordinate = false;      ///< the first is not an axis but the items' coordinates
};

/// Items in bricks; brick p, q, r has the number (p slabs[1] + q) slabs[2] + r.
struct Bricks {
  Slabs slabs;
  std::vector<std::uint32_t> numbers;  ///< brick of each of this rank's items
};

/// Sorted by how far they reach along the first direction into slabs[0] parts of equal weight, each along the
/// second into slabs[1], each along the third into slabs[2]. Zero slabs: chosen so that `num_subdomains`
/// bricks of the items' box have the least interface; all along a coordinate.
Bricks pqr_decomposition(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains, Slabs slabs,
                         SlabDirections directions);

/// Items in groups, each of which is to become one or more subdomains.
struct Bisected {
  std::vector<std::uint32_t> groups;  ///< of each of this rank's items
  std::vector<std::uint32_t> sizes;   ///< subdomains of each group; they are numbered on through the groups
};

/// By how far items reach, halves (as nearly as the number of subdomains allows) the groups of more than one
/// subdomain for which cut(number of items, number of subdomains) holds, across the axis that is longest in
/// wanted sizes (cutting_axis). Groups of more than a rank's share, or of more than 20,000 items, are cut
/// by all ranks together, smaller ones each by one rank. The result is the same on any number of ranks.
Bisected bisect(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains,
                const std::function<bool(std::uint64_t, std::uint32_t)>& cut);

/// Halves everything until each part is one subdomain.
std::vector<SubdomainId> bisection(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains);

/// The P, Q, R of product `num_subdomains` that cut a box of these sides with the least area of interfaces;
/// of equal ones that with the greatest P, then Q.
Slabs suitable_slabs(std::uint32_t num_subdomains, const meshing::Vec& sides);

}  // namespace weft::partition
