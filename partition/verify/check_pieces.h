// The invariants of distributed data that the parts of a mesh show, checked over all ranks.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "meshing/mesh/problems.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// What the whole mesh must add up to.
struct ExpectedTotals {
  double volume = 0;
  std::map<std::int32_t, double> area_by_ref;  ///< triangle reference -> area
  double volume_tolerance = 0;                 ///< beside 1e-9 of the volume
  bool areas_known = true;                     ///< else areas are not compared
};

/// What check_pieces found, the same on all ranks. `problems` holds at most `max_problems` sentences in
/// alphabetical order; vertices are named by their global ids, other entities by subdomain and 1-based
/// number.
struct PiecesReport {
  std::vector<std::string> problems;
  std::uint64_t num_problems = 0;
  double volume = 0;                           ///< of all tets
  std::map<std::int32_t, double> area_by_ref;  ///< triangle reference -> area, each triangle once
  bool ok() const { return num_problems == 0; }
};

/// All ranks: checks of every piece that its arrays fit each other and hold what they may
/// (meshing::check_arrays; ids valid and different, `shared` sorted and in range). Where this fails the rest
/// is left out. Then: every tet exactly POSITIVE; no two tets with the same vertices, wherever they are;
/// every face in one or two tets, which lie on its two sides, also where they are in two pieces; triangles,
/// of the same reference on both sides, on all faces of one tet and between tets of different references;
/// every triangle a face of its piece; copies of a vertex with equal bits of coordinates and metrics;
/// `shared` of every copy naming exactly the other pieces that have the vertex; volume and areas as expected
/// to 1e-9 of the value. Which of more than max_problems problems are named may depend on the ranks. Sends
/// every vertex and tet of the mesh once. `name_ranks`: as gather_problems().
PiecesReport check_pieces(Peers& peers, std::span<const MeshPiece> mine,
                          const std::optional<ExpectedTotals>& expected = {}, int max_problems = 20,
                          bool name_ranks = false);

/// All ranks: adds what each has found to the report of all, at most as many sentences as the list may have;
/// with `name_ranks` each ends in "(found on rank 3)".
void gather_problems(Peers& peers, meshing::Problems&& found, bool name_ranks, PiecesReport& report);

}  // namespace weft::partition
