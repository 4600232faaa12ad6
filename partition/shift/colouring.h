// Decentralised colouring after Luby (1986): who receives is decided by what a subdomain and its neighbours
// know of each other's priorities.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "partition/subdomain/interface.h"

namespace weft::partition {

/// How much a subdomain wants to receive. A strict total order: by value, equal values by id.
struct Priority {
  std::uint64_t value = 0;
  SubdomainId id;
  friend auto operator<=>(const Priority&, const Priority&) = default;
};

/// The priority of a subdomain in a round: who has more poor tets receives before those who have fewer, as
/// in the paper. Counts are told apart by factors of two, and among alike ones who comes first changes from
/// round to round. Who is `full` comes after all who are not: poor tets are received too, so that who has
/// received would receive again and again.
Priority priority_in(std::uint64_t round, SubdomainId subdomain, std::uint64_t poor_tets, bool full);

/// A subdomain and its neighbours in the order of their priorities: places 1 and up, the last one receives
/// from all. The holders of a vertex know each other's priorities, so they agree on who receives there.
class ReceiverOrder {
 public:
  /// Place in the order; kNobody stands for no subdomain.
  using Place = std::uint32_t;
  static constexpr Place kNobody = 0;

  /// `neighbours`: their priorities, ascending by id.
  ReceiverOrder(const Priority& self, std::span<const Priority> neighbours);

  Place self() const { return self_; }
  /// Places are 0 (kNobody) to size() - 1.
  std::size_t size() const { return order_.size() + 1; }
  SubdomainId subdomain(Place place) const { return order_[place - 1].id; }
  Place place_of(SubdomainId neighbour) const;
  /// How many neighbours come before this subdomain. 0: it receives from all of them; subdomains of this
  /// colour are an independent set of the adjacency graph, never an empty one.
  std::size_t above_self() const { return order_.size() - self_; }
  /// Who receives the tets around a vertex that this subdomain and `others` hold.
  Place receiver(std::span<const Holder> others) const;

 private:
  std::vector<Priority> order_;   ///< ascending
  std::vector<SubdomainId> ids_;  ///< of the neighbours, ascending
  std::vector<Place> place_;      ///< of the neighbours
  Place self_ = kNobody;
};

}  // namespace weft::partition
