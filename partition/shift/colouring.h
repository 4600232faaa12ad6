// Decentralised colouring after Luby (1986): who may receive is decided by what a subdomain and its
// neighbours know.
#pragma once

#include <compare>
#include <cstdint>
#include <span>

#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// How much a subdomain wants to receive. A strict total order: by value, equal ones by id.
struct Priority {
  std::uint64_t value = 0;
  SubdomainId id = 0;
  friend auto operator<=>(const Priority&, const Priority&) = default;
};

/// Whether the subdomain of priority `mine` receives: it is greater than every neighbour that takes part.
/// Where neighbours know each other's priorities, no two of them receive in one round, and one subdomain at
/// least does. A maximal independent set comes of repeating the question among those that neither receive nor
/// have a neighbour that does.
bool receives(const Priority& mine, std::span<const Priority> neighbours);

}  // namespace weft::partition
