// Fills what a subdomain starts from.
#pragma once

#include <span>

#include "partition/distribute/point_records.h"
#include "partition/distribute/tet_records.h"
#include "partition/subdomain/subdomain_start.h"
#include "partition/surface/boundary_index.h"

namespace weft::partition {

/// The start of one subdomain, its vertices in the order of the input. `points` are sorted by number and have
/// at least the tets' vertices. `compact`: the tets are in an order in which those of a piece of the
/// background lie together, and keep it.
SubdomainStart build_start(SubdomainId subdomain, std::span<const TetRecord> tets,
                           std::span<const PointRecord> points, const Holders& holders,
                           const BoundaryIndex& boundary, bool compact);

}  // namespace weft::partition
