// Writes the result of all subdomains, by all ranks at once and without gathering it.
#pragma once

#include <filesystem>
#include <span>

#include "partition/communication/peers.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// All ranks: writes one .meshb, or .ugrid (is_ugrid_for_parts), and beside it one .solb of the metrics
/// unless `solution` is empty. The bytes are those that write_gmf_mesh, write_ugrid and write_gmf_solution
/// would write for merge_pieces() of all pieces, whatever rank has which. Each rank writes its part into a
/// temporary file beside the target, which all ranks must see; rank 0 renames it when all have succeeded.
/// When any rank fails all throw the same meshing::InputError and nothing is left. Text files (.mesh, .sol)
/// are refused. `carried`, of rank 0: the CAD model to be in the file, as bytes. `version`: of GMF, 0 chooses
/// (write_gmf_mesh).
void write_pieces(Peers& peers, std::span<const MeshPiece> mine, const std::filesystem::path& mesh,
                  const std::filesystem::path& solution = {}, const meshing::Association& carried = {},
                  int version = 0);

}  // namespace weft::partition
