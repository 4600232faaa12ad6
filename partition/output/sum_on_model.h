// How a result in pieces lies on the CAD model of its surface.
#pragma once

#include <span>

#include "meshing/kernel/on_model.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/subdomain_start.h"

namespace weft::partition {

/// What one piece adds: meshing::sum_on_model() of its share.
struct PieceOnModel {
  SubdomainId subdomain;
  meshing::ModelSums sums;
};

/// All ranks: the sums over all pieces, the same bits whoever has them. Vertices are not listed: pieces have
/// numbers of their own.
meshing::ModelSums sum_on_model(Peers& peers, std::span<const PieceOnModel> mine);

}  // namespace weft::partition
