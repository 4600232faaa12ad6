// Records of vertices, or of what has a lowest vertex, meet at the home of that vertex: the rank that its
// number modulo the ranks names. Whoever has the vertex asks there.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/release.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks: the vertices that each rank asks for here.
inline std::vector<std::vector<std::uint32_t>> asked_at_home(Peers& peers,
                                                             const std::vector<std::uint32_t>& vertices) {
  std::vector<std::vector<std::uint32_t>> asked(static_cast<std::size_t>(peers.ranks()));
  for (const std::uint32_t v : vertices) asked[v % asked.size()].push_back(v);
  return partition::all_to_all(peers, std::move(asked));
}

/// All ranks: the records at the vertices that each rank has `asked` for here. `here` is sorted by
/// `vertex_of`.
template <class T, class VertexOf>
std::vector<T> told_at_home(Peers& peers, const std::vector<std::vector<std::uint32_t>>& asked,
                            std::vector<T> here, const VertexOf& vertex_of) {
  std::vector<std::vector<T>> answers(asked.size());
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const std::uint32_t v : asked[r]) {
      const auto found = std::ranges::equal_range(here, v, {}, vertex_of);
      answers[r].insert(answers[r].end(), found.begin(), found.end());
    }
  meshing::release(here);
  return all_to_all_joined(peers, std::move(answers));
}

/// All ranks: the same of records of edges, whose `vertices` ascend: those between vertices that this rank
/// has asked for, `mine` (ascending). `here` is sorted by lower vertices.
template <class T>
std::vector<T> told_between(Peers& peers, const std::vector<std::vector<std::uint32_t>>& asked,
                            const std::vector<std::uint32_t>& mine, std::vector<T> here) {
  std::vector<T> found =
      told_at_home(peers, asked, std::move(here), [](const T& edge) { return edge.vertices[0]; });
  std::erase_if(found, [&](const T& edge) { return !std::ranges::binary_search(mine, edge.vertices[1]); });
  return found;
}

}  // namespace weft::partition
