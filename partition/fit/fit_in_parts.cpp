// Blocks across the ends of shares are summed by the rank that has their first tet.
#include "partition/fit/fit_in_parts.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using meshing::FitSums;

/// What a rank has of a block that others have tets of too.
struct BlockPart {
  std::uint64_t block;
  FitSums sums;
};

/// All ranks: whether the blocks fit whose parts arrive here.
bool parts_fit(Peers& peers, std::vector<std::vector<BlockPart>> to_each, FitSums& all) {
  std::vector<BlockPart> parts = all_to_all_joined(peers, std::move(to_each));
  std::ranges::sort(parts, {}, &BlockPart::block);
  bool fit = true;
  for (auto part = parts.begin(); part != parts.end();) {
    FitSums sums;
    const std::uint64_t block = part->block;
    for (; part != parts.end() && part->block == block; ++part) sums += part->sums;
    fit = fit && sums.fits();
    all += sums;
  }
  return fit;
}

}  // namespace

std::optional<meshing::MetricFit> fit_in_parts(Peers& peers, const MeshPiece& piece) {
  const Ranges tets(peers, piece.mesh.tets.size());
  const auto blocks = meshing::sum_blocks(piece.mesh.tets, tets.first(peers.rank()), tets.total(),
                                          piece.mesh.points, piece.log_metrics);
  FitSums all;
  std::vector<std::vector<BlockPart>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t b = 0; blocks && b < blocks->sums.size(); ++b) {
    const std::uint64_t block = blocks->first + b;
    const FitSums& sums = blocks->sums[b];
    const std::uint64_t first = meshing::first_of_block(block, tets.total());
    if (sums.tets == meshing::first_of_block(block + 1, tets.total()) - first)
      all += sums;
    else
      to_each[tets.rank_of(first)].push_back({block, sums});
  }
  // Where a rank has found a block that does not fit its parts are missing, which no longer matters.
  const bool rest_fits = parts_fit(peers, std::move(to_each), all);
  const std::uint64_t misfit = blocks && rest_fits ? 0 : 1;
  const std::vector<std::uint64_t> sums =
      partition::sum(peers, std::vector{misfit, all.tets, all.longer, all.shorter, all.quality, all.volume});
  if (sums[0] > 0) return {};
  return FitSums{sums[1], sums[2], sums[3], 0, sums[4], sums[5]}.shares();
}

}  // namespace weft::partition
