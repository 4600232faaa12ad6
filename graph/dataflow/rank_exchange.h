// Payloads from every rank to every rank, between the runs of an engine, by point-to-point messages.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/serialize.h"
#include "engine/objects/registry.h"
#include "engine/run/runtime.h"

namespace weft::graph::dataflow {

/// An all-to-all exchange through a mailbox object of each rank, which has the rank's first id: so the others
/// know its address without asking.
class RankExchange {
 public:
  static constexpr std::uint32_t kObjects = 1;  ///< that it makes on every rank, before all others

  static void register_types(engine::Registry& registry);

  /// All ranks must make it before any other object is made, else the run that this is fails
  /// (engine::RunFailure); another one for the same runtime uses the same mailboxes. `runtime` must outlive
  /// it.
  explicit RankExchange(engine::Runtime& runtime);

  engine::Runtime& runtime() const { return runtime_; }

  /// Sends to_each[r] to rank r and returns what each rank has sent here, [r] from rank r; both have one
  /// entry a rank. All ranks must call it; one run of the engine, so that nothing of it is on its way before
  /// or after. Throws engine::RunFailure on all ranks.
  std::vector<engine::Payload> exchange(std::vector<engine::Payload> to_each);

 private:
  engine::Runtime& runtime_;
};

}  // namespace weft::graph::dataflow
