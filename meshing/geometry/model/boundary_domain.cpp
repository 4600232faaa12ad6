// What a whole boundary finds by itself.
#include "meshing/geometry/model/boundary_domain.h"

#include <algorithm>

namespace weft::meshing {

void FaceTally::add(const FaceTally& other) {
  triangles += other.triangles;
  for (std::size_t i = 0; i < sides.size(); ++i) sides[i] += other.sides[i];
  farthest = std::max(farthest, other.farthest);
}

std::vector<double> WholeBoundaryDomain::select(std::vector<double> mine,
                                                std::span<const std::uint64_t> places) const {
  std::ranges::sort(mine);
  std::vector<double> found;
  for (const std::uint64_t place : places) found.push_back(mine[place]);
  return found;
}

}  // namespace weft::meshing
