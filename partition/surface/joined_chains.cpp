// Each rank joins its own edges to chains; where these end open, chains of ranks meet.
#include "partition/surface/joined_chains.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <utility>

#include "meshing/base/number_sets.h"

namespace weft::partition {
namespace {

/// Of a rank's features.
struct Chains {
  std::vector<std::uint32_t> of_feature;
  std::vector<std::uint64_t> edges;  // by chain, how many
};

/// Where a chain goes on elsewhere.
struct OpenEnd {
  std::uint32_t vertex, rank, chain;
  auto order() const { return std::tuple{vertex, rank, chain}; }
};

struct ChainLink {
  std::array<OpenEnd, 2> ends;
};

Chains chains_of(std::span<const meshing::FoundFeature> mine, std::uint32_t rank,
                 std::vector<OpenEnd>& open) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;  // vertices that are no corners, and features
  for (std::uint32_t f = 0; f < mine.size(); ++f)
    for (std::size_t i = 0; i < 2; ++i)
      if (!mine[f].corners[i]) ends.emplace_back(mine[f].vertices[i], f);
  std::ranges::sort(ends);
  meshing::NumberSets sets(mine.size());
  std::vector<std::size_t> alone;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const bool after = i > 0 && ends[i - 1].first == ends[i].first;
    const bool before = i + 1 < ends.size() && ends[i + 1].first == ends[i].first;
    if (after) sets.unite(ends[i - 1].second, ends[i].second);
    if (!after && !before) alone.push_back(i);
  }
  Chains chains;
  for (std::uint32_t f = 0; f < mine.size(); ++f) {
    const std::uint32_t root = sets.of(f);
    if (root == f) chains.edges.push_back(0);
    chains.of_feature.push_back(root == f ? static_cast<std::uint32_t>(chains.edges.size() - 1)
                                          : chains.of_feature[root]);
    ++chains.edges[chains.of_feature[f]];
  }
  for (const std::size_t i : alone) open.push_back({ends[i].first, rank, chains.of_feature[ends[i].second]});
  return chains;
}

/// All ranks: open ends meet where their vertex says.
std::vector<ChainLink> links_of(Peers& peers, const std::vector<OpenEnd>& open) {
  std::vector<std::vector<OpenEnd>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const OpenEnd& end : open) to_each[end.vertex % to_each.size()].push_back(end);
  std::vector<OpenEnd> here = all_to_all_joined(peers, std::move(to_each));
  std::ranges::sort(here, {}, &OpenEnd::order);
  std::vector<ChainLink> mine;
  for (std::size_t i = 1; i < here.size(); ++i)
    if (here[i - 1].vertex == here[i].vertex) mine.push_back({{here[i - 1], here[i]}});
  return allgather_joined(peers, mine);
}

}  // namespace

std::vector<std::size_t> homes_of_curves(Peers& peers, std::span<const meshing::FoundFeature> mine) {
  const auto me = static_cast<std::uint32_t>(peers.rank());
  std::vector<OpenEnd> open;
  const Chains chains = chains_of(mine, me, open);
  const std::vector<ChainLink> links = links_of(peers, open);
  std::vector<std::uint64_t> edges;
  std::vector<std::uint32_t> first;  // chain of each rank
  for (const std::vector<std::uint64_t>& of_rank : partition::allgather(peers, chains.edges)) {
    first.push_back(static_cast<std::uint32_t>(edges.size()));
    edges.insert(edges.end(), of_rank.begin(), of_rank.end());
  }
  meshing::NumberSets sets(edges.size());
  for (const auto& [ends] : links)
    sets.unite(first[ends[0].rank] + ends[0].chain, first[ends[1].rank] + ends[1].chain);
  for (std::uint32_t c = 0; c < edges.size(); ++c)
    if (const std::uint32_t root = sets.of(c); root != c) edges[root] += std::exchange(edges[c], 0);
  const std::uint64_t total = std::accumulate(edges.begin(), edges.end(), std::uint64_t{0});
  std::uint64_t passed = 0;
  std::vector<std::size_t> homes(edges.size());  // of chains that name their sets
  for (std::uint32_t c = 0; c < edges.size(); ++c) {
    if (edges[c] > 0) homes[c] = passed * static_cast<std::uint64_t>(peers.ranks()) / total;
    passed += edges[c];
  }
  std::vector<std::size_t> of_mine;
  for (const std::uint32_t chain : chains.of_feature) of_mine.push_back(homes[sets.of(first[me] + chain)]);
  return of_mine;
}

}  // namespace weft::partition
