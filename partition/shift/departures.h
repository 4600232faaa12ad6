// Vertices affected by the tets that leave a subdomain, and the removal of these tets.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "partition/shift/choice.h"

namespace weft::partition {

/// A vertex with a subdomain that tets around it go to (or stay in). Ordered by global id.
struct Departure {
  GlobalId id;
  SubdomainId to;
  std::uint32_t vertex;
  friend auto operator<=>(const Departure&, const Departure&) = default;
};

struct Departures {
  /// Sorted: where the tets around a vertex go, for interface vertices not all of whose tets stay and for
  /// vertices that become interface vertices. An inner vertex that leaves with all its tets for one
  /// subdomain concerns no third one.
  std::vector<Departure> of_interface;
  std::vector<std::uint8_t> is_of_interface;  ///< by slot: whether `of_interface` has the vertex
  /// Vertices of leaving tets, each with a tet that stays; invalid where none does.
  std::vector<std::uint32_t> vertices;
  std::vector<meshing::TetId> staying;
};

/// `interface_index`: by vertex slot, Interface::kNone for vertices that are not of the interface.
Departures find_departures(const Subdomain& subdomain, const ReceiverOrder& order, const Chosen& chosen,
                           const std::vector<std::uint32_t>& interface_index);

/// Removes the tets that leave, and the vertices that have none left.
void remove_leaving(Subdomain& subdomain, const Chosen& chosen, const Departures& departures);

}  // namespace weft::partition
