// Pieces of the surface from the ranks that can make them to those whose subdomains are near.
#pragma once

#include <span>
#include <vector>

#include "meshing/geometry/surface/cut_surface.h"
#include "meshing/geometry/surface/surface_piece.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/subdomain_start.h"
#include "partition/subdomain/surface_cover.h"

namespace weft::partition {

/// Fills SubdomainStart::surface with the pieces that each start asks for (subdomain/surface_cover.h). Each
/// piece is made by the rank whose cutter has it (null: a rank that has none), once for each rank that it may
/// be near to, and is kept by those alone that it is near to. A few of them are under way at a time. All
/// ranks call together.
void hand_out_pieces(Peers& peers, const meshing::SurfaceCutter* cutter, std::span<SubdomainStart> starts);

/// All ranks: the same for whoever has a cover, ascending by id.
std::vector<std::vector<meshing::SurfacePieces::Piece>> pieces_near(Peers& peers,
                                                                    const meshing::SurfaceCutter* cutter,
                                                                    std::span<const SurfaceCover> covers);

}  // namespace weft::partition
