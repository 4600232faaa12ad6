// METIS on groups of items, each whole on one rank: the only source that names it.
#include "partition/decompose/graph_partition.h"

#include <metis.h>

#include <algorithm>
#include <functional>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <type_traits>

#include "meshing/base/release.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/decompose/dual_graph.h"
#include "partition/decompose/slabs.h"

namespace weft::partition {
namespace {

/// A group of more items a subdomain than this is a graph, if it is small enough.
constexpr std::uint64_t kLeastPerSubdomain = 8;
/// Groups are halved further for a large mesh, as long as so many subdomains are left to a half: of fewer,
/// most of the interface would be planes.
constexpr std::uint32_t kLeastOfGroup = 10;
/// Groups of more tets are halved also where so many subdomains are left to a half: planes are few among as
/// many interfaces, and more ranks have something to divide. What is left is divided by recursion.
constexpr std::uint64_t kWorthDealing = 10'000;
constexpr std::uint32_t kManyOfGroup = 70;
/// Recursion cuts 3 to 4 % less than METIS's direct division, in two to three times the time: what small
/// groups need, for what bisection cuts more, and what a graph of few subdomains costs least.
constexpr std::uint32_t kMostByRecursion = 8;

static_assert(std::is_same_v<idx_t, std::int32_t>, "DualGraph is passed to METIS as it is");

/// An item on its way to the rank that divides its group.
struct Traveller {
  std::uint32_t group;
  DualVertex tet;
};

/// In METIS's 32 bits: at least 1, all together below 2^30.
template <class T>
std::vector<idx_t> small_weights(const std::vector<T>& weights) {
  double total = 0;
  for (const T w : weights) total += static_cast<double>(w);
  const double scale = total > 0 ? 0x1p29 / total : 0;
  std::vector<idx_t> result;
  result.reserve(weights.size());
  for (const T w : weights)
    result.push_back(std::max<idx_t>(1, static_cast<idx_t>(static_cast<double>(w) * scale)));
  return result;
}

/// What a group has at most, in items. Small groups occupy many ranks, but planes between them cut more: they
/// become small as the mesh grows from twice to ten times what may be in a graph, where ranks are many
/// and planes too. Not by the number of ranks, on which no result depends.
struct GroupLimits {
  GroupLimits(std::uint64_t total, std::uint64_t most_in_graph)
      : most(most_in_graph), of_many(most_in_graph) {
    constexpr std::uint64_t kLarge = 2, kShare = 5;
    if (total <= kLarge * most) return;
    of_many = std::max(most / kShare, kLarge * most * most / total);
    by_recursion = most / 2;
  }
  std::uint64_t most;
  std::uint64_t of_many;           ///< of subdomains enough for two groups
  std::uint64_t by_recursion = 0;  ///< to be divided by recursion into any number of parts
};

/// A graph as METIS takes it.
struct MetisGraph {
  std::vector<idx_t> begins, neighbours, weights, face_weights;
};

/// No tet counts for more than a part: one that has more is a part by itself, and the others are divided as
/// if it were not there. METIS would look for cuts where there are no tets, and say so on stdout.
void limit_to_parts(std::vector<std::uint64_t>& work, std::uint32_t num_parts) {
  std::uint64_t total = std::accumulate(work.begin(), work.end(), std::uint64_t{0});
  if (std::ranges::max(work) <= total / num_parts) return;
  std::vector<std::uint64_t> heaviest_first = work;
  std::ranges::sort(heaviest_first, std::greater<>());
  std::uint64_t parts = num_parts;
  for (const std::uint64_t of_tet : heaviest_first) {
    if (parts == 1 || of_tet <= total / parts) break;
    total -= of_tet;
    --parts;
  }
  const std::uint64_t most = std::max<std::uint64_t>(1, total / parts);
  for (std::uint64_t& of_tet : work) of_tet = std::min(of_tet, most);
}

/// Gives the tets' memory back.
MetisGraph metis_graph(std::vector<DualVertex>&& tets, std::uint32_t num_parts) {
  std::vector<std::uint64_t> work;
  work.reserve(tets.size());
  for (const DualVertex& tet : tets) work.push_back(tet.weight);
  limit_to_parts(work, num_parts);
  MetisGraph graph;
  graph.weights = small_weights(work);
  meshing::release(work);
  DualGraph dual = dual_graph(tets);
  meshing::release(tets);
  graph.face_weights = small_weights(dual.face_weights);
  graph.begins = std::move(dual.begins);
  graph.neighbours = std::move(dual.neighbours);
  return graph;
}

/// The part, below num_parts, of each tet.
std::vector<idx_t> metis_parts(MetisGraph graph, std::uint32_t num_parts, bool recursive) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;  // the same parts in every run
  auto num_vertices = static_cast<idx_t>(graph.weights.size());
  auto parts_wanted = static_cast<idx_t>(num_parts);
  idx_t one_weight = 1, cut = 0;
  std::vector<idx_t> part(graph.weights.size());
  const auto divide = recursive ? METIS_PartGraphRecursive : METIS_PartGraphKway;
  // METIS draws from rand(): two graphs at once in a process would get each other's numbers.
  static std::mutex one_at_a_time;
  const std::scoped_lock lock(one_at_a_time);
  const int status =
      divide(&num_vertices, &one_weight, graph.begins.data(), graph.neighbours.data(), graph.weights.data(),
             nullptr, graph.face_weights.data(), &parts_wanted, nullptr, nullptr, options, &cut, part.data());
  if (status != METIS_OK) throw std::runtime_error("METIS could not divide the graph of the tets");
  return part;
}

/// The items of the groups that are to be divided, sent to the ranks that do it.
std::vector<std::vector<Traveller>> send_groups(Peers& peers, const WeightedItems& items,
                                                const ItemFaces& faces, const Bisected& bisected) {
  std::vector<std::vector<Traveller>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t i = 0; i < bisected.groups.size(); ++i) {
    const std::uint32_t g = bisected.groups[i];
    if (bisected.sizes[g] == 1) continue;
    to_each[g % to_each.size()].push_back(
        {g, {items.numbers[i], items.weights[i], faces.vertices[i], faces.areas[i]}});
  }
  return partition::all_to_all(peers, std::move(to_each));
}

/// Groups one after the other, and where each tet has come from.
struct ArrivedGroups {
  struct Group {
    std::uint32_t number;
    std::vector<DualVertex> tets;
  };
  struct Origin {
    std::uint32_t rank, place;
  };
  std::vector<Group> groups;
  std::vector<Origin> origins;
};

/// Tets are in the order of their numbers, so that no graph depends on who sent what. Gives the travellers'
/// memory back.
ArrivedGroups in_groups(std::vector<std::vector<Traveller>>&& arrived) {
  struct Key {
    std::uint64_t number;
    std::uint32_t group;
    ArrivedGroups::Origin origin;
  };
  std::vector<Key> keys;
  std::size_t size = 0;
  for (const auto& of_rank : arrived) size += of_rank.size();
  keys.reserve(size);
  for (std::uint32_t r = 0; r < arrived.size(); ++r)
    for (std::uint32_t i = 0; i < arrived[r].size(); ++i)
      keys.push_back({arrived[r][i].tet.number, arrived[r][i].group, {r, i}});
  const auto comes_before = [](const Key& a, const Key& b) {
    return a.group != b.group ? a.group < b.group : a.number < b.number;
  };
  if (!std::ranges::is_sorted(keys, comes_before)) std::ranges::sort(keys, comes_before);
  ArrivedGroups result;
  result.origins.reserve(size);
  for (auto begin = keys.begin(); begin != keys.end();) {
    const auto end = std::find_if(begin, keys.end(), [&](const Key& k) { return k.group != begin->group; });
    result.groups.push_back({begin->group, {}});
    std::vector<DualVertex>& tets = result.groups.back().tets;
    tets.reserve(static_cast<std::size_t>(end - begin));
    for (; begin != end; ++begin) {
      tets.push_back(arrived[begin->origin.rank][begin->origin.place].tet);
      result.origins.push_back(begin->origin);
    }
  }
  meshing::release(arrived);
  return result;
}

/// The part of each traveller in its group, in the order of arrival.
std::vector<std::vector<std::uint32_t>> divide(std::vector<std::vector<Traveller>>&& arrived,
                                               const Bisected& bisected, const GroupLimits& limits) {
  std::vector<std::vector<std::uint32_t>> parts;
  for (const auto& of_rank : arrived) parts.emplace_back(of_rank.size());
  ArrivedGroups all = in_groups(std::move(arrived));
  auto origin = all.origins.begin();
  for (ArrivedGroups::Group& group : all.groups) {
    const std::uint32_t num_parts = bisected.sizes[group.number];
    const std::uint64_t count = group.tets.size();
    const bool is_dealt =
        bisected.sizes.size() > 1 && num_parts >= kManyOfGroup && count <= 2 * kWorthDealing;
    const bool recursive = num_parts <= kMostByRecursion || count <= limits.by_recursion || is_dealt;
    for (const idx_t part :
         metis_parts(metis_graph(std::move(group.tets), num_parts), num_parts, recursive)) {
      parts[origin->rank][origin->place] = static_cast<std::uint32_t>(part);
      ++origin;
    }
  }
  return parts;
}

Bisected bisect_into_groups(Peers& peers, const WeightedItems& items, std::uint32_t num_subdomains,
                            const GroupLimits& limits) {
  return bisect(peers, items, num_subdomains, [&](std::uint64_t count, std::uint32_t size) {
    if (size >= 2 * kManyOfGroup && count > kWorthDealing) return true;
    const bool halves_are_enough = size >= 2 * kLeastOfGroup;
    return count > (halves_are_enough ? limits.of_many : limits.most) || count < kLeastPerSubdomain * size;
  });
}

}  // namespace

std::vector<SubdomainId> graph_partition(Peers& peers, const WeightedItems& items, const ItemFaces& faces,
                                         std::uint32_t num_subdomains, std::uint64_t most_in_graph,
                                         const std::function<void()>& items_are_read) {
  const GroupLimits limits(partition::sum(peers, std::uint64_t{items.numbers.size()}), most_in_graph);
  const Bisected bisected = bisect_into_groups(peers, items, num_subdomains, limits);
  std::vector<std::vector<Traveller>> arrived = send_groups(peers, items, faces, bisected);
  if (items_are_read) items_are_read();
  std::vector<std::vector<std::uint32_t>> parts(arrived.size());
  agree_on(peers, [&] { parts = divide(std::move(arrived), bisected, limits); });
  parts = partition::all_to_all(peers, std::move(parts));

  std::vector<std::uint32_t> first(bisected.sizes.size(), 0);
  std::exclusive_scan(bisected.sizes.begin(), bisected.sizes.end(), first.begin(), 0u);
  std::vector<std::size_t> next(parts.size(), 0);
  std::vector<SubdomainId> result;
  result.reserve(bisected.groups.size());
  for (const std::uint32_t g : bisected.groups) {
    const std::size_t r = g % parts.size();
    result.emplace_back(first[g] + (bisected.sizes[g] == 1 ? 0 : parts[r][next[r]++]));
  }
  return result;
}

}  // namespace weft::partition
