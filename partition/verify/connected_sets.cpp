// Every node knows one that is joined with it and has a smaller number, in the end the smallest.
#include "partition/verify/connected_sets.h"

#include <algorithm>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using Edge = std::array<std::uint64_t, 2>;

class Forest {
 public:
  Forest(Peers& peers, std::uint64_t mine) : peers_(peers), nodes_(peers, mine), parents_(mine) {
    for (std::uint64_t i = 0; i < mine; ++i) parents_[i] = nodes_.first(peers.rank()) + i;
  }

  /// Both ends of each edge become the roots of their trees; edges within a tree go.
  void contract(std::vector<Edge>& edges) const {
    std::vector<std::uint64_t> ends;
    for (const Edge& edge : edges) ends.insert(ends.end(), edge.begin(), edge.end());
    meshing::sort_unique(ends);
    const std::vector<std::uint64_t> roots = parents_of(ends);
    const auto root = [&](std::uint64_t end) { return roots[meshing::place_in(ends, end)]; };
    for (Edge& edge : edges) {
      edge = {root(edge[0]), root(edge[1])};
      std::ranges::sort(edge);
    }
    std::erase_if(edges, [](const Edge& edge) { return edge[0] == edge[1]; });
    meshing::sort_unique(edges);
  }

  /// Links roots to the smallest ones that edges join them with.
  void hook(const std::vector<Edge>& edges) {
    std::vector<std::vector<Edge>> to_each(static_cast<std::size_t>(peers_.ranks()));
    for (const Edge& edge : edges) to_each[nodes_.rank_of(edge[1])].push_back(edge);
    for (const auto& of_rank : partition::all_to_all(peers_, std::move(to_each)))
      for (const auto& [smaller, root] : of_rank) {
        std::uint64_t& parent = parents_[root - nodes_.first(peers_.rank())];
        parent = std::min(parent, smaller);
      }
  }

  /// Until every parent is a root.
  void compress() {
    for (std::uint8_t changed = 1; changed != 0; changed = partition::max(peers_, changed)) {
      changed = 0;
      std::vector<std::uint64_t> wanted = parents_;
      meshing::sort_unique(wanted);
      const std::vector<std::uint64_t> grandparents = parents_of(wanted);
      for (std::uint64_t& parent : parents_) {
        const std::uint64_t next = grandparents[meshing::place_in(wanted, parent)];
        changed |= next != parent;
        parent = next;
      }
    }
  }

  std::uint64_t count_roots() const {
    std::uint64_t roots = 0;
    for (std::uint64_t i = 0; i < parents_.size(); ++i)
      roots += parents_[i] == nodes_.first(peers_.rank()) + i;
    return partition::sum(peers_, roots);
  }

 private:
  std::vector<std::uint64_t> parents_of(const std::vector<std::uint64_t>& nodes) const {
    return fetch<std::uint64_t>(peers_, nodes_, nodes, [&](std::size_t i) { return parents_[i]; });
  }

  Peers& peers_;
  Ranges nodes_;
  std::vector<std::uint64_t> parents_;
};

}  // namespace

std::uint64_t count_connected_sets(Peers& peers, std::uint64_t mine, std::vector<Edge> edges) {
  Forest forest(peers, mine);
  for (;;) {
    forest.contract(edges);
    if (partition::sum(peers, std::uint64_t{edges.size()}) == 0) return forest.count_roots();
    forest.hook(edges);
    forest.compress();
  }
}

}  // namespace weft::partition
