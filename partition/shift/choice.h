// Which tets leave a subdomain in a shift, and where they go.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "partition/shift/shift.h"

namespace weft::partition {

/// Subdomains by their place in the order of priorities, 1 and up; 0 stands for nobody.
using Rank = std::uint32_t;
inline constexpr Rank kNobody = 0;

/// What has been chosen for each tet.
struct Chosen {
  std::vector<Rank> to;                 ///< by slot; kNobody for tets that stay
  std::vector<meshing::TetId> leaving;  ///< ascending
  bool leaves(meshing::TetId t) const { return to[t.value] != kNobody; }
};

/// Chooses for each tet the subdomain that it goes to.
class Choice {
 public:
  /// `proposals` as for gather().
  Choice(const Subdomain& subdomain, const Priority& mine, std::span<const Proposal> proposals);

  Rank self() const { return self_; }
  SubdomainId subdomain(Rank r) const { return order_[r - 1].id; }
  std::size_t ranks() const { return order_.size() + 1; }

  Chosen choose(std::span<const GlobalId> wanted, std::span<const Proposal> proposals,
                const ShiftOptions& options);

 private:
  Rank rank_of(SubdomainId neighbour) const;
  bool seed(std::span<const GlobalId> wanted);
  void take_at_vertices();
  void spread_to_vertices();
  void take_across_faces();

  const Subdomain& s_;
  const meshing::TetMesh& mesh_;
  std::vector<Priority> order_;
  Rank self_ = kNobody;
  std::vector<Rank> rank_of_neighbour_;
  std::vector<Rank> vertex_, tet_;
  std::vector<std::uint32_t> taken_;  ///< tets of the last layer
  std::vector<std::pair<std::uint32_t, Rank>> next_;
};

}  // namespace weft::partition
