// The invariants of distributed data (DESIGN.md, section 3) between two rounds of a run: what --check looks
// at.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "meshing/mesh/problems.h"
#include "partition/subdomain/geometry.h"
#include "partition/subdomain/subdomain.h"
#include "partition/verify/check_pieces.h"

namespace weft::partition {

/// An invariant does not hold; the text names subdomain, entity and rank.
struct InvariantViolation : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One subdomain by itself: the table of the interface fits the mesh and the frozen vertices, all vertices of
/// faces to other subdomains are frozen, and neighbours of tets are mutual.
void check_interface(const Subdomain& subdomain, const Geometry& geometry, meshing::Problems& problems);

/// All ranks, while no message is under way: check_interface() of every subdomain, and check_pieces() of
/// copies of all of them. The subdomains stay as they are. Takes memory for a copy of them.
PiecesReport check_subdomains(Peers& peers, std::span<const Subdomain* const> mine, const Geometry& geometry,
                              const std::optional<ExpectedTotals>& expected = {}, int max_problems = 20);

/// Throws InvariantViolation with what has been found; `when`: "after shift 2".
void throw_if_violated(const PiecesReport& report, const std::string& when);

/// What must stay while a subdomain is adapted: the vertices of its interface.
class InterfaceSnapshot {
 public:
  explicit InterfaceSnapshot(const Subdomain& before);
  /// Throws InvariantViolation naming a vertex that is gone, is frozen no more, or has moved by any bit.
  void check(const Subdomain& after) const;

 private:
  struct Vertex {
    GlobalId id;
    meshing::Point point;
  };
  std::vector<Vertex> vertices_;
};

/// Volume and areas that later checks are to find again. Areas, and the volume to rounding, only where the
/// boundary is planar with straight features; elsewhere the volume to what moving the surface by `distance`
/// may change.
ExpectedTotals totals_to_keep(const PiecesReport& at_first, const Geometry& geometry, double distance);

}  // namespace weft::partition
