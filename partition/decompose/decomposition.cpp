// Dispatches to the partitioners.
#include "partition/decompose/decomposition.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "partition/communication/reduce.h"
#include "partition/decompose/graph_partition.h"
#include "partition/decompose/ordered_cuts.h"
#include "partition/decompose/slabs.h"
#include "partition/decompose/thin_slabs.h"

namespace weft::partition {

namespace {

std::vector<SubdomainId> as_subdomains(const Bricks& bricks) {
  return {bricks.numbers.begin(), bricks.numbers.end()};
}

/// Of slabs that are mostly interface: what they cost, and what would be better.
std::string advice_on(const WorthwhileSlabs& worthwhile, const Slabs& asked) {
  const Slabs& s = worthwhile.slabs;
  return fmt::format(
      "{}x{}x{} slabs have about {:.0f} % of the vertices in interfaces, which are adapted twice; as many "
      "subdomains by the graph partitioner have about {:.0f} %, {}x{}x{} slabs about {:.0f} % (`:fewer` "
      "after the slabs makes these)",
      asked[0], asked[1], asked[2], 100 * worthwhile.share_asked, 100 * worthwhile.share_cubes, s[0], s[1],
      s[2], 100 * worthwhile.share_left);
}

Decomposition pqr(Peers& peers, const WeightedItems& weighted, const Items& items,
                  std::uint32_t num_subdomains, const Partitioner& partitioner) {
  const SlabDirections directions{partitioner.principal_axes, partitioner.coordinate.asked()};
  Bricks bricks = pqr_decomposition(peers, weighted, num_subdomains, partitioner.slabs, directions);
  const Slabs asked = bricks.slabs;
  const WorthwhileSlabs worthwhile =
      worthwhile_slabs(peers, {items.vertices, items.face_areas}, items.complexities, bricks);
  const Slabs& left = worthwhile.slabs;
  if (left == asked) return {as_subdomains(bricks), {}};
  if (!partitioner.fewer) return {as_subdomains(bricks), advice_on(worthwhile, asked)};
  const std::uint64_t bricks_left = num_bricks(left);
  bricks = pqr_decomposition(peers, weighted, static_cast<std::uint32_t>(bricks_left), left, directions);
  // Bricks are spread over the numbers of subdomains, as subdomains are over the ranks.
  for (std::uint32_t& brick : bricks.numbers)
    brick = static_cast<std::uint32_t>(std::uint64_t{brick} * num_subdomains / bricks_left);
  return {
      as_subdomains(bricks),
      fmt::format("{} of {} subdomains stay empty: {}x{}x{} slabs would have about {:.0f} % of the vertices "
                  "in interfaces, {}x{}x{} have about {:.0f} %",
                  num_subdomains - bricks_left, num_subdomains, asked[0], asked[1], asked[2],
                  100 * worthwhile.share_asked, left[0], left[1], left[2], 100 * worthwhile.share_left)};
}

}  // namespace

Decomposition decompose(Peers& peers, const Items& items, std::uint32_t num_subdomains,
                        const Partitioner& partitioner, const std::function<void()>& items_are_read) {
  if (num_subdomains == 0) throw std::invalid_argument("a mesh cannot be decomposed into 0 subdomains");
  const auto& slabs = partitioner.slabs;
  if (const std::uint64_t product = num_bricks(slabs); product != 0 && product != num_subdomains)
    throw std::invalid_argument(fmt::format("a decomposition into {}x{}x{} slabs has {} subdomains, not {}",
                                            slabs[0], slabs[1], slabs[2], product, num_subdomains));
  const std::vector<std::uint64_t> weights = integer_weights(peers, items.work);
  const bool by_coordinate = partitioner.coordinate.asked();
  if (by_coordinate && items.coordinates.size() != items.work.size())
    throw std::invalid_argument("slabs along a coordinate of the boundary: the tets have none");
  const WeightedItems weighted{items.centres, items.corners,     weights,
                               items.numbers, items.cut_tensors, items.coordinates};
  switch (partitioner.kind) {
    case Partitioner::Kind::pqr:
      return pqr(peers, weighted, items, num_subdomains, partitioner);
    case Partitioner::Kind::graph:
      return {graph_partition(peers, weighted, {items.vertices, items.face_areas}, num_subdomains,
                              kMostInGraph, items_are_read),
              {}};
    case Partitioner::Kind::bisection:
      break;
  }
  return {bisection(peers, weighted, num_subdomains), {}};
}

std::vector<std::uint32_t> apportion(std::span<const std::uint64_t> work, std::uint32_t num) {
  const double all = static_cast<double>(std::accumulate(work.begin(), work.end(), std::uint64_t{0}));
  const auto left = num - static_cast<std::uint32_t>(work.size());
  std::vector<std::uint32_t> of_each(work.size(), 1);
  std::vector<std::pair<double, std::size_t>> remainders;  // negative: the largest comes first
  std::uint32_t given = 0;
  for (std::size_t i = 0; i < work.size(); ++i) {
    const double share = all > 0 ? left * (static_cast<double>(work[i]) / all) : 0;
    const auto whole = std::min(static_cast<std::uint32_t>(share), left - given);
    of_each[i] += whole;
    given += whole;
    remainders.emplace_back(whole - share, i);
  }
  std::sort(remainders.begin(), remainders.end());
  for (std::size_t k = 0; given < left; ++k, ++given) ++of_each[remainders[k % remainders.size()].second];
  return of_each;
}

Decomposition with_room_to_divide(Peers& peers, Decomposition decomposition, std::span<const double> work,
                                  std::uint32_t parts, std::uint32_t num_subdomains) {
  const std::vector<std::uint64_t> weights = integer_weights(peers, work);
  std::vector<std::uint64_t> of_part(parts, 0);
  for (std::size_t t = 0; t < weights.size(); ++t) of_part[decomposition.subdomains[t].value] += weights[t];
  const std::vector<std::uint32_t> of_each = apportion(partition::sum(peers, of_part), num_subdomains);
  SubdomainId first(0);
  for (const std::uint32_t n : of_each) {
    decomposition.seeds.push_back(first);
    first.value += n;
  }
  for (SubdomainId& s : decomposition.subdomains) s = decomposition.seeds[s.value];
  return decomposition;
}

}  // namespace weft::partition
