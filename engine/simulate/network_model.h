// What a packet costs on a network: latency, bandwidth and gap (LogGP), and switches that share their
// uplinks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/rank.h"

namespace weft::engine {

/// What is between the ports of ranks.
enum class Topology {
  flat,       ///< one switch that is never busy
  tree,       ///< switches of `switch_ranks` ranks, each with an uplink of half the bandwidth of its ports
  fat_tree,   ///< the same as SimGrid has it: each switch joined to as many others as half its ranks
  dragonfly,  ///< SimGrid's: routers of `switch_ranks` ranks, in groups
};
/// Whether it is one that SimGrid simulates, by flows that share links (flow_network.h).
constexpr bool has_flows(Topology topology) {
  return topology == Topology::fat_tree || topology == Topology::dragonfly;
}

/// Alexandrov et al., LogGP: One step closer to a realistic model of parallel computation, SPAA 1995. Each
/// rank has a port of its own that takes one packet at a time in each direction.
struct NetworkModel {
  double latency = 2e-6;    ///< seconds from port to port
  double bandwidth = 10e9;  ///< bytes a second of a port
  double gap = 2e-7;        ///< seconds a port is busy with a packet of no bytes
  double overhead = 5e-7;   ///< seconds a rank's communication thread takes to send or receive a packet

  /// Packets between switches of a tree take `latency` more, and share an uplink. SimGrid's topologies know
  /// latency, bandwidth and overhead; a packet passes links of half the latency, and there is no gap.
  Topology topology = Topology::flat;
  int switch_ranks = 0;  ///< where there are switches
};

/// "LATENCY,BANDWIDTH[,flat|tree:N|fat-tree:N|dragonfly:N]": seconds or with a unit (2us, 50us), bytes a
/// second (10GB/s); latencies to 10 s, bandwidths from 1,000 B/s. Throws std::invalid_argument that says what
/// is expected.
NetworkModel parse_network(std::string_view text);
/// The opposite, for reports.
std::string text_of(const NetworkModel& network);

/// Who uses which link until when, on a flat network or a tree. Packets must be sent in the order of time,
/// more or less.
class NetworkLinks {
 public:
  NetworkLinks(const NetworkModel& network, int ranks);

  /// A packet of `bytes` is handed over at `time`; returns when it has arrived.
  std::int64_t send(Rank from, Rank to, std::size_t bytes, std::int64_t time);

 private:
  struct Port {
    std::int64_t out = 0;  ///< free from then on
    std::int64_t in = 0;
  };
  NetworkModel network_;
  std::vector<Port> ports_;
  std::vector<Port> uplinks_;  ///< by switch
};

}  // namespace weft::engine
