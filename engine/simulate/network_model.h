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

/// Alexandrov et al., LogGP: One step closer to a realistic model of parallel computation, SPAA 1995. Each
/// rank has a port of its own that takes one packet at a time in each direction.
struct NetworkModel {
  double latency = 2e-6;    ///< seconds from port to port
  double bandwidth = 10e9;  ///< bytes a second of a port
  double gap = 2e-7;        ///< seconds a port is busy with a packet of no bytes
  double overhead = 5e-7;   ///< seconds a rank's communication thread takes to send or receive a packet

  /// Ranks a switch; 0: all are on one. Packets between switches take `latency` more, and share an uplink of
  /// half the bandwidth of the ports below it (a fat tree tapered 2 : 1).
  int switch_ranks = 0;
};

/// "LATENCY,BANDWIDTH[,flat|tree:N]": seconds or with a unit (2us, 50us), bytes a second (10GB/s). Throws
/// std::invalid_argument that says what is expected.
NetworkModel parse_network(std::string_view text);
/// The opposite, for reports.
std::string text_of(const NetworkModel& network);

/// Who uses which link until when. Packets must be sent in the order of time, more or less.
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
