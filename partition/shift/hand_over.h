// Hands tets that have been chosen over to other subdomains.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "partition/shift/choice.h"
#include "partition/shift/shift.h"

namespace weft::partition {

/// Who gets a parcel.
struct Receiver {
  SubdomainId id;
  std::span<const std::uint64_t> pieces;   ///< of the background, that it has already; ascending
  std::span<const std::uint32_t> surface;  ///< the same of the surface
  /// Of the background, that its new tets cover beside those of their vertices; ascending. Empty: not known.
  std::span<const std::uint64_t> covered;
};

/// A parcel for each receiver, in their order; removes what leaves from the mesh, and notes in
/// Subdomain::departures where it has gone. `receivers`, ascending: all neighbours of the interface, who must
/// know what has left, and all who get tets. `order` knows those by the places in `chosen`.
std::vector<Parcel> hand_over(Subdomain& subdomain, const ReceiverOrder& order, const Chosen& chosen,
                              std::span<const Receiver> receivers);

}  // namespace weft::partition
