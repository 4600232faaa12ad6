// Dispatches to the partitioners.
#include "partition/decomposition.h"

#include <fmt/format.h>

#include <stdexcept>

#include "partition/graph_partition.h"
#include "partition/ordered_cuts.h"
#include "partition/slabs.h"

namespace weft::partition {

std::vector<SubdomainId> decompose(Peers& peers, const Items& items, std::uint32_t num_subdomains,
                                   const Partitioner& partitioner) {
  if (num_subdomains == 0) throw std::invalid_argument("a mesh cannot be decomposed into 0 subdomains");
  const auto& slabs = partitioner.slabs;
  if (const std::uint64_t product = std::uint64_t{slabs[0]} * slabs[1] * slabs[2];
      product != 0 && product != num_subdomains)
    throw std::invalid_argument(fmt::format("a decomposition into {}x{}x{} slabs has {} subdomains, not {}",
                                            slabs[0], slabs[1], slabs[2], product, num_subdomains));
  const std::vector<std::uint64_t> weights = integer_weights(peers, items.work);
  const WeightedItems weighted{items.centres, weights, items.numbers, items.cut_tensors};
  switch (partitioner.kind) {
    case Partitioner::Kind::pqr:
      return pqr_decomposition(peers, weighted, num_subdomains, slabs, partitioner.principal_axes);
    case Partitioner::Kind::graph:
      return graph_partition(peers, weighted, {items.vertices, items.face_areas}, num_subdomains);
    case Partitioner::Kind::bisection:
      break;
  }
  return bisection(peers, weighted, num_subdomains);
}

}  // namespace weft::partition
