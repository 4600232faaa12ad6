// Which pieces of the background the parts of a divided mesh cover.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// By part, ids of the pieces that have a tet whose centre is in it; ascending. `tets`: of the subdomain's
/// mesh, by slots of its vertices; `parts`: of each, below num_parts. Beside the pieces that vertices are in,
/// which are not looked for here, what this leaves out of a part's background is less than a tet of a piece.
/// (BackgroundCover asks the tets of the mesh where they are: for a few of them that is less to do, but many
/// steps a tet that is much larger than those of the background.)
std::vector<std::vector<std::uint64_t>> pieces_of_parts(const Subdomain& subdomain,
                                                        std::span<const std::array<std::uint32_t, 4>> tets,
                                                        std::span<const SubdomainId> parts,
                                                        std::uint32_t num_parts);

}  // namespace weft::partition
