// Who is near whom: a grid over two meshes, and boxes about a part's tets.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/fields/cell_grid.h"
#include "partition/metric/part_domain.h"

namespace weft::partition {

meshing::Box box_of(const meshing::MeshData& mesh, const meshing::Tet& tet);

/// All ranks: a grid over both meshes, a few points of the coarser one a cell.
CellGrid common_grid(Peers& peers, const PartDomain& a, const PartDomain& b);

/// About `most` boxes at most (more where vertices with large tets have very many), half of them of a tet
/// each, at the vertices that have the largest, the others of the tets at about equally many vertices; grown
/// by the largest `reach` (of each vertex; none: 0) in them. Those that follow each other are near each
/// other. (In a graded mesh a box of a few large tets would have the fine part in it.)
std::vector<meshing::Box> boxes_of_tets(const meshing::MeshData& mesh, std::size_t most,
                                        std::span<const double> reach = {});

/// All ranks: of the boxes around each rank that is asked, those that meet `where`; none of others.
std::vector<std::vector<meshing::Box>> ask_for_boxes(Peers& peers, std::span<const int> asked,
                                                     const meshing::Box& where,
                                                     std::span<const meshing::Box> around);

/// What is found at a distance (infinity: nothing) is the nearest once all within it is there: whether
/// `reach` had to grow for that. `diameter`: of all that there is.
inline bool widen_reach(double distance, double diameter, double& reach) {
  constexpr double kRounding = 1 + 1e-6, kFirstReach = 1.0 / 64;
  const double wanted =
      std::isfinite(distance) ? kRounding * distance : std::max(4 * reach, kFirstReach * diameter);
  if (wanted <= reach || reach >= diameter) return false;
  reach = wanted;
  return true;
}

}  // namespace weft::partition
