// Vertices that the input lists as corners or as required.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/kernel/tet_mesh.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/at_home.h"
#include "partition/communication/peers.h"

namespace weft::partition {

struct ListedPoint {
  std::uint32_t vertex;
  std::uint32_t flags;  ///< meshing::kListedCorner, kListedRequired
};

/// All ranks: those whose home this is (at_home.h), each once, ascending. Each rank has a share of the lists.
inline std::vector<ListedPoint> listed_points_at_home(Peers& peers, const meshing::MeshData& lists) {
  std::vector<std::vector<ListedPoint>> to_each(static_cast<std::size_t>(peers.ranks()));
  const auto add = [&](const std::vector<std::uint32_t>& list, std::uint32_t flag) {
    for (const std::uint32_t v : list) to_each[v % to_each.size()].push_back({v, flag});
  };
  add(lists.corners, meshing::kListedCorner);
  add(lists.required_points, meshing::kListedRequired);
  std::vector<ListedPoint> all = all_to_all_joined(peers, std::move(to_each));
  std::ranges::sort(all, {}, &ListedPoint::vertex);
  std::size_t end = 0;
  for (const ListedPoint& p : all) {
    if (end > 0 && all[end - 1].vertex == p.vertex)
      all[end - 1].flags |= p.flags;
    else
      all[end++] = p;
  }
  all.resize(end);
  return all;
}

/// All ranks: lists those among `vertices` (ascending) by their places there; `asked`: asked_at_home() of
/// these.
inline void take_listed_points(Peers& peers, const std::vector<std::vector<std::uint32_t>>& asked,
                               std::vector<ListedPoint> at_home, const std::vector<std::uint32_t>& vertices,
                               meshing::MeshData& mesh) {
  std::vector<ListedPoint> here =
      told_at_home(peers, asked, std::move(at_home), [](const ListedPoint& p) { return p.vertex; });
  std::ranges::sort(here, {}, &ListedPoint::vertex);
  for (const ListedPoint& p : here) {
    const auto place = static_cast<std::uint32_t>(meshing::place_in(vertices, p.vertex));
    if (p.flags & meshing::kListedCorner) mesh.corners.push_back(place);
    if (p.flags & meshing::kListedRequired) mesh.required_points.push_back(place);
  }
}

}  // namespace weft::partition
