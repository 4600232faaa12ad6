// Packets as flows that share links: when one arrives depends on what else is under way until then.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/rank.h"
#include "engine/simulate/network_model.h"

namespace weft::engine {

/// Nanoseconds of virtual time. One at a time in a process.
class FlowNetwork {
 public:
  struct Arrival {
    std::uint64_t packet;
    std::int64_t time;
  };
  virtual ~FlowNetwork() = default;

  /// `packet`, a number that names it, sets off at `time`, which is no earlier than what was simulated
  /// already.
  virtual void send(std::uint64_t packet, Rank from, Rank to, std::size_t bytes, std::int64_t time) = 0;

  /// Goes on until packets arrive, or to `until`; returns those that do, none later than that.
  virtual std::vector<Arrival> advance(std::int64_t until) = 0;
};

/// For the topologies of SimGrid, whose part of weft is loaded when the first one is made. Throws
/// std::invalid_argument where it is missing.
std::unique_ptr<FlowNetwork> make_flow_network(const NetworkModel& network, int ranks);

/// The one function of that part. `interface` is kFlowInterface of the caller; null is returned for another.
using FlowEntry = FlowNetwork* (*)(int interface, const NetworkModel* network, int ranks);
inline constexpr const char* kFlowEntryName = "weft_simgrid_network";
inline constexpr int kFlowInterface = 1;

}  // namespace weft::engine
