// The invariants of distributed data, checked over all ranks: for tests and for --check.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// What the whole mesh must add up to.
struct ExpectedTotals {
  double volume = 0;
  std::map<std::int32_t, double> area_by_ref;  ///< triangle reference -> area
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
/// every vertex and tet of the mesh once.
PiecesReport check_pieces(Peers& peers, std::span<const MeshPiece> mine,
                          const std::optional<ExpectedTotals>& expected = {}, int max_problems = 20);

}  // namespace weft::partition
