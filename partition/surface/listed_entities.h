// What the lists of a boundary in shares name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/surface/boundary_share.h"

namespace weft::partition {

/// An entity of this rank that a list names.
struct Named {
  std::uint32_t place;    ///< among this rank's
  std::uint64_t in_list;  ///< place in the whole list
};

/// All ranks: which entities of this rank's range are on the list, of which each rank has a share.
inline std::vector<Named> named_here(Peers& peers, const Ranges& ranges,
                                     const std::vector<std::uint32_t>& list) {
  struct Entry {
    std::uint64_t number, in_list;
  };
  const Ranges places(peers, list.size());
  std::vector<std::vector<Entry>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t i = 0; i < list.size(); ++i)
    to_each[ranges.rank_of(list[i])].push_back({list[i], places.first(peers.rank()) + i});
  std::vector<Named> named;
  for (const Entry& entry : all_to_all_joined(peers, std::move(to_each)))
    named.push_back({static_cast<std::uint32_t>(entry.number - ranges.first(peers.rank())), entry.in_list});
  return named;
}

/// All ranks: this rank's triangles.
inline std::vector<BoundaryTriangle> listed_triangles(Peers& peers, const meshing::MeshData& m) {
  const Ranges ranges(peers, m.triangles.size());
  std::vector<BoundaryTriangle> listed;
  listed.reserve(m.triangles.size());
  for (std::size_t i = 0; i < m.triangles.size(); ++i)
    listed.push_back(
        {static_cast<std::uint32_t>(ranges.first(peers.rank()) + i), m.triangles[i], m.triangle_refs[i], 0});
  for (const Named& named : named_here(peers, ranges, m.required_triangles)) listed[named.place].required = 1;
  return listed;
}

}  // namespace weft::partition
