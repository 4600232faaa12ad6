#include "tools/library/parts/part_ghosts.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace weft::tools {
namespace {

using partition::Peers;

struct GhostPoint {
  std::uint64_t id;
  Point x;
  Tensor log_metric;
  std::int32_t ref, owner;
};

struct GhostTet {
  std::array<std::uint64_t, 4> ids;
  std::int64_t ref;
};

/// The other ranks that have a vertex of the tet, each once.
std::vector<int> ranks_at(const std::array<std::uint32_t, 4>& tet,
                          const std::vector<std::vector<int>>& holders) {
  std::vector<int> ranks;
  for (const std::uint32_t v : tet)
    for (const int rank : holders[v])
      if (std::ranges::find(ranks, rank) == ranks.end()) ranks.push_back(rank);
  return ranks;
}

}  // namespace

void add_ghosts(Peers& peers, const std::vector<std::vector<int>>& holders, Part& part,
                std::vector<Tensor>& log_metrics) {
  const auto ranks = static_cast<std::size_t>(peers.ranks());
  std::vector<std::vector<GhostTet>> tets(ranks);
  std::vector<std::vector<GhostPoint>> points(ranks);
  std::vector<std::unordered_set<std::uint32_t>> sent(ranks);
  Mesh& mesh = part.mesh;
  for (std::size_t t = 0; t < part.num_own_tets; ++t)
    for (const int rank : ranks_at(mesh.tets[t], holders)) {
      const auto r = static_cast<std::size_t>(rank);
      GhostTet ghost{{}, mesh.tet_refs[t]};
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t v = mesh.tets[t][i];
        ghost.ids[i] = part.ids[v];
        if (sent[r].insert(v).second)
          points[r].push_back(
              {part.ids[v], mesh.points[v], log_metrics[v], mesh.point_refs[v], part.owners[v]});
      }
      tets[r].push_back(ghost);
    }
  points = partition::all_to_all(peers, points);
  tets = partition::all_to_all(peers, tets);
  std::unordered_map<std::uint64_t, std::uint32_t> index;
  for (std::size_t v = 0; v < part.ids.size(); ++v) index.emplace(part.ids[v], static_cast<std::uint32_t>(v));
  for (std::size_t r = 0; r < ranks; ++r) {
    for (const GhostPoint& p : points[r]) {
      if (!index.try_emplace(p.id, static_cast<std::uint32_t>(part.ids.size())).second) continue;
      part.ids.push_back(p.id);
      part.owners.push_back(p.owner);
      mesh.points.push_back(p.x);
      mesh.point_refs.push_back(p.ref);
      log_metrics.push_back(p.log_metric);
    }
    for (const GhostTet& tet : tets[r]) {
      std::array<std::uint32_t, 4> vertices{};
      for (std::size_t i = 0; i < 4; ++i) vertices[i] = index.at(tet.ids[i]);
      mesh.tets.push_back(vertices);
      mesh.tet_refs.push_back(static_cast<std::int32_t>(tet.ref));
      part.ghost_owners.push_back(static_cast<int>(r));
    }
  }
}

}  // namespace weft::tools
