// Payloads from every rank to every rank, between the runs of an engine, by point-to-point messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/base/serialize.h"
#include "engine/objects/registry.h"
#include "engine/run/runtime.h"

namespace weft::graph::dataflow {

/// Exchanges through a mailbox object of each rank, which has the rank's first id: so the others know its
/// address without asking. All ranks must call the same functions in the same order; each is one run of the
/// engine, which a rank leaves when it has what comes to it. They throw engine::RunFailure, on ranks that
/// have left the next time.
class RankExchange {
 public:
  static constexpr std::uint32_t kObjects = 1;  ///< that it makes on every rank, before all others

  static void register_types(engine::Registry& registry);

  /// All ranks must make it before any other object is made, else the run that this is fails
  /// (engine::RunFailure); another one for the same runtime uses the same mailboxes. `runtime` must outlive
  /// it.
  explicit RankExchange(engine::Runtime& runtime);

  engine::Runtime& runtime() const { return runtime_; }

  /// Payloads of at least so many bytes go straight to their rank: there sending them costs more than the
  /// message does.
  static constexpr std::size_t kDirectBytes = std::size_t{1} << 15;

  /// Sends to_each[r] to rank r and returns what each rank has sent here, [r] from rank r; both have one
  /// entry a rank. Empty ones are not sent. Small ones travel together, in steps of 1, 2, 4, ... ranks (the
  /// method of Bruck et al., 1997): one message a step and rank, log2 of the ranks in all, whoever sends to
  /// whom.
  std::vector<engine::Payload> exchange(std::vector<engine::Payload> to_each);

  using Bytes = std::vector<std::byte>;
  /// What each rank gives, [r] of rank r, on all ranks: log2 of the ranks in messages, one after the other
  /// (two more where that is no whole number). Half the steps of a tree, up and down.
  std::vector<Bytes> allgather(Bytes mine);
  /// The same, one after the other in the order of the ranks.
  Bytes allgather_joined(Bytes mine);

  /// Puts the second, of higher ranks, into the first. In which groups depends on the number of ranks.
  using Combine = std::function<void(Bytes& sum, const Bytes& more)>;
  /// What all ranks give, combined, on all ranks; in the same way.
  Bytes reduce(Bytes mine, const Combine& combine);

 private:
  engine::Runtime& runtime_;
};

}  // namespace weft::graph::dataflow
