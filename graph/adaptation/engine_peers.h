// The ranks of an engine as the peers of partition's algorithms.
#pragma once

#include <vector>

#include "graph/dataflow/rank_exchange.h"
#include "partition/communication/peers.h"

namespace weft::graph::adaptation {

/// Each exchange is one run of the engine. To be made on all ranks before the runtime has other objects:
/// see RankExchange.
class EnginePeers final : public partition::Peers {
 public:
  static constexpr std::uint32_t kObjects = dataflow::RankExchange::kObjects;

  static void register_types(engine::Registry& registry) { dataflow::RankExchange::register_types(registry); }

  /// `runtime` must outlive it.
  explicit EnginePeers(engine::Runtime& runtime) : exchange_(runtime) {}

  int rank() const override { return exchange_.runtime().rank().value; }
  int ranks() const override { return exchange_.runtime().ranks(); }
  std::vector<partition::Bytes> all_to_all(std::vector<partition::Bytes> to_each) override;
  std::vector<partition::Bytes> allgather(partition::Bytes mine) override;
  partition::Bytes allgather_joined(partition::Bytes mine) override;
  partition::Bytes reduce(partition::Bytes mine, const Combine& combine) override;

 private:
  dataflow::RankExchange exchange_;
};

}  // namespace weft::graph::adaptation
