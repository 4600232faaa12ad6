// Sources are made when they are asked for, and again with what is farther off.
#include "partition/fields/part_pair.h"

#include <algorithm>

#include "partition/fields/surroundings.h"

namespace weft::partition {
namespace {

/// For each vertex a thousandth of the size of its tets: what is computed of a point or a tet may be by
/// rounding that of another one that it only touches.
std::vector<double> reach_of_rounding(const meshing::MeshData& mesh) {
  constexpr double kShare = 1e-3;
  std::vector<double> reach(mesh.points.size(), 0);
  for (const meshing::Tet& tet : mesh.tets) {
    const double share = kShare * norm(box_of(mesh, tet).size());
    for (const std::uint32_t v : tet) reach[v] = std::max(reach[v], share);
  }
  return reach;
}

}  // namespace

PartPair::PartPair(Peers& peers, const MeshSlice& from, const MeshSlice& to,
                   const std::atomic<bool>* interrupt)
    : PartPair(peers, from, to, morton_shares(peers, {from.points, to.points}), interrupt) {}

PartPair::PartPair(Peers& peers, const MeshSlice& from, const MeshSlice& to, const MortonShares& shares,
                   const std::atomic<bool>* interrupt)
    : peers_(peers),
      old_(peers, from, 1, shares, interrupt),
      new_(meshing::of_new_mesh([&] { return PartDomain(peers, to, 1, shares, interrupt); })),
      diameter_(norm(shares.box.size())),
      reach_(reach_of_rounding(new_.mesh())) {}

const NearbyTets& PartPair::nearby() const {
  if (!nearby_) nearby_.reset(new NearbyTets(peers_, old_, new_, reach_));
  return *nearby_;
}

bool PartPair::widen(std::span<const double> distances) {
  bool wider = false;
  for (std::size_t v = 0; v < distances.size(); ++v) wider |= widen_reach(distances[v], diameter_, reach_[v]);
  if (!old_.any(wider)) return false;
  nearby_.reset();
  return true;
}

}  // namespace weft::partition
