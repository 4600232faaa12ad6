// Many ranks in one process: the transport for tests and for debugging a distributed run in one debugger.
#pragma once

#include <memory>
#include <vector>

#include "engine/network/transport.h"

namespace weft::engine {

/// A network of `ranks` ranks within this process; each rank's transport is to be used by a thread of its
/// own.
class LoopbackNetwork {
 public:
  enum class OnAbandon { carry_on, exit };

  /// `on_abandon`: what abandon() does: tell the other ranks and carry on, as a test wants it, or end the
  /// process at once with status 2.
  explicit LoopbackNetwork(int ranks, OnAbandon on_abandon = OnAbandon::carry_on);
  ~LoopbackNetwork();

  Transport& transport(Rank rank);

  /// As if the rank's process were gone: what is sent to it vanishes, and the others' lost_peer() tells.
  void kill(Rank rank);

 private:
  class Node;
  struct Shared;
  std::unique_ptr<Shared> shared_;
  std::vector<std::unique_ptr<Node>> nodes_;
};

}  // namespace weft::engine
