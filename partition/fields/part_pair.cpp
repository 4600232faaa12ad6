// Sources are made when they are asked for, and again with a wider margin.
#include "partition/fields/part_pair.h"

namespace weft::partition {

PartPair::PartPair(Peers& peers, const MeshSlice& from, const MeshSlice& to)
    : peers_(peers), old_(peers, from, 1), new_(peers, to, 1) {}

const NearbyTets& PartPair::nearby(Way way) const {
  const Side& s = side(way);
  const bool back = way == Way::back;
  if (!s.tets) {
    side(back ? Way::onto_new : Way::back).tets.reset();  // who goes back has done with the way there
    s.tets.reset(new NearbyTets(peers_, back ? new_ : old_, back ? old_ : new_, s.margin));
  }
  return *s.tets;
}

bool PartPair::widen(Way way, double distance) {
  constexpr std::uint32_t kAll = 64;  // cells along an axis, at most
  Side& s = sides_[way == Way::back];
  if (s.tets && distance <= s.tets->reach()) return false;
  if (s.margin >= kAll) return false;
  s.margin *= 4;
  s.tets.reset();
  return true;
}

}  // namespace weft::partition
