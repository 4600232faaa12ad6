// Which tets leave a subdomain in a shift, and where they go.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "partition/shift/shift.h"

namespace weft::partition {

using Place = ReceiverOrder::Place;
inline constexpr Place kNobody = ReceiverOrder::kNobody;

/// What has been chosen for each tet.
struct Chosen {
  std::vector<Place> to;                ///< receiver by slot; kNobody for tets that stay
  std::vector<meshing::TetId> leaving;  ///< ascending
  bool leaves(meshing::TetId t) const { return to[t.value] != kNobody; }
};

/// Chooses for each tet the subdomain that it goes to.
class Choice {
 public:
  /// `proposals` as for gather().
  Choice(const Subdomain& subdomain, const Priority& mine, std::span<const Proposal> proposals);

  const ReceiverOrder& order() const { return order_; }

  Chosen choose(std::span<const GlobalId> wanted, std::span<const Proposal> proposals,
                const ShiftOptions& options);

 private:
  bool seed(std::span<const GlobalId> wanted);
  void take_at_vertices();
  void spread_to_vertices();
  void take_across_faces();

  const Subdomain& s_;
  const meshing::TetMesh& mesh_;
  ReceiverOrder order_;
  std::vector<Place> vertex_, tet_;
  std::vector<std::uint32_t> taken_;    ///< tets of the last layer
  std::vector<std::uint32_t> reached_;  ///< vertices of these that have no subdomain yet
  std::vector<Place> of_reached_;       ///< by slot; kNobody for others
  std::vector<std::pair<std::uint32_t, Place>> next_;
};

}  // namespace weft::partition
