// Sources are made when they are asked for, and again with what is farther off.
#include "partition/fields/part_pair.h"

#include <algorithm>
#include <cmath>

namespace weft::partition {
namespace {

/// For each vertex a thousandth of the size of its tets: what is computed of a point or a tet may be by
/// rounding that of another one that it only touches.
std::vector<double> reach_of_rounding(const meshing::MeshData& mesh) {
  constexpr double kShare = 1e-3;
  std::vector<double> reach(mesh.points.size(), 0);
  for (const meshing::Tet& tet : mesh.tets) {
    meshing::Box box;
    for (const std::uint32_t v : tet) box.include(mesh.points[v]);
    const double share = kShare * norm(box.size());
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
      diameter_(norm(shares.box.size())) {
  sides_[false].reach = reach_of_rounding(new_.mesh());
  sides_[true].reach = reach_of_rounding(old_.mesh());
}

const NearbyTets& PartPair::nearby(Way way) const {
  const Side& s = side(way);
  const bool back = way == Way::back;
  if (!s.tets) {
    side(back ? Way::onto_new : Way::back).tets.reset();  // who goes back has done with the way there
    s.tets.reset(new NearbyTets(peers_, back ? new_ : old_, back ? old_ : new_, s.reach));
  }
  return *s.tets;
}

/// What is found at a distance is the nearest once all within it is there.
bool PartPair::widen(Way way, std::span<const double> distances) {
  constexpr double kRounding = 1 + 1e-6, kFirstReach = 1.0 / 64;
  Side& s = sides_[way == Way::back];
  bool wider = false;
  for (std::size_t v = 0; v < distances.size(); ++v) {
    const double wanted = std::isfinite(distances[v]) ? kRounding * distances[v]
                                                      : std::max(4 * s.reach[v], kFirstReach * diameter_);
    if (wanted <= s.reach[v] || s.reach[v] >= diameter_) continue;
    s.reach[v] = wanted;
    wider = true;
  }
  if (!old_.any(wider)) return false;
  s.tets.reset();
  return true;
}

}  // namespace weft::partition
