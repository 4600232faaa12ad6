// Bytes from every rank to every rank, between the runs of an engine, by point-to-point messages.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/registry.h"
#include "engine/runtime.h"

namespace weft::graph::dataflow {

/// An all-to-all exchange through a mailbox object of each rank, which has the rank's first id: so the others
/// know its address without asking. Throws std::logic_error when the runtime already has other objects.
class RankExchange {
 public:
  using Bytes = std::vector<std::byte>;

  static void register_types(engine::Registry& registry);

  /// All ranks must make it before any other object is made; another one for the same runtime uses the same
  /// mailboxes. `runtime` must outlive it.
  explicit RankExchange(engine::Runtime& runtime);

  engine::Runtime& runtime() const { return runtime_; }

  /// Sends to_each[r] to rank r and returns what each rank has sent here. All ranks must call it; one run of
  /// the engine, so neither before nor after it anything of another exchange is on its way.
  std::vector<Bytes> exchange(std::vector<Bytes> to_each);

 private:
  engine::Runtime& runtime_;
};

}  // namespace weft::graph::dataflow
