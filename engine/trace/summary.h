// What a run did, in numbers: of each rank, and of all together; as structs that travel and as JSON.
//
// JSON, schema "weft-engine-1". Times are seconds, sizes bytes; VOLUME stands for
// "sent": {"messages": 3, "bytes": 120}, "received": {"messages": 2, "bytes": 80}.
//
// Of a rank:
//
//     {"rank": 0, "workers": 2,
//      "wall": 1.25,                      of the engine's loop
//      "compute": 2.0, "unpack": 0.01,    of all workers
//      "copy": 0.0,                       of all workers: copies of objects for snapshots
//      "help": 0.0,                       of other threads, in the place of workers without a handler: at
//                                         the parallel loops of handlers
//      "idle": 0.49,                      of all workers: the rest of workers * wall
//      "pack": 0.02,
//      "communication": 0.1,              processor time of the communication thread, packing included
//      "worker_compute": [1.1, 0.9],
//      "methods": [{"name": "Part::refine", "count": 40, "seconds": 2.0, "longest": 0.2, VOLUME}],
//                                         those that ran or had messages; "": the engine's own
//      "traffic": {"invoke": {VOLUME}, "signal": {VOLUME}, "migrate": {VOLUME}, "forward": {VOLUME}},
//                                         "migrate": one message for each object that moved
//      "peers": [{"rank": 1, VOLUME}],    those with messages
//      "network_calls": {"MPI_Isend": 120},
//      "collective_calls": 0,             how many of them are collective
//      "counters": {"steals": 3},         whatever the program counts
//      "peak_rss": 104857600,
//      "dropped_spans": 0}                spans and departures that a timeline lacks
//
// Of a run:
//
//     {"schema": "weft-engine-1", "ranks": 4,   how many
//      "workers": 8,                      of all ranks; so are the times but for "wall"
//      "wall": 1.3,                       the longest
//      "compute": 8.0, "unpack": 0.04, "copy": 0.0, "help": 0.0, "idle": 2.3, "pack": 0.08, "communication":
//      0.4, "load_imbalance": 1.2,             compute + help per worker: the most of any rank / mean; 1 is
//      best "idle_share": 0.22,                idle / (workers * wall) "balance_saving": 0.23,            1 -
//      ((compute + help) / workers) / wall "verdict": "perfect balance would save 23 % of 1.3 s", "methods":
//      [...], "traffic": {...}, "network_calls": {...}, "collective_calls": 0,
//                                         as of a rank, summed
//      "counters": {"steals": {"sum": 7, "min": 0, "max": 3}},
//      "peak_rss": {"sum": 419430400, "max": 125829120}, "dropped_spans": 0,
//      "consistent": {"messages": true, "bytes": true,    as many sent as received, of each traffic
//                     "pairs": true},                     and from each rank to each
//      "per_rank": [...]}                 the ranks' own; empty where the run kept its sums alone
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/rank.h"
#include "engine/trace/trace.h"

namespace weft::engine {

struct MethodSummary {
  std::string name;  ///< empty: no method (the engine's own messages)
  std::uint64_t count = 0;
  double seconds = 0;
  double longest = 0;  ///< seconds
  Volume volume;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(name, count, seconds, longest, volume);
  }
};

struct PeerSummary {
  Rank rank;
  Volume volume;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(rank, volume);
  }
};

/// Seconds of a rank's threads; those of the workers are summed.
struct TimeSummary {
  double compute = 0;        ///< workers
  double unpack = 0;         ///< workers
  double copy = 0;           ///< workers, for snapshots
  double help = 0;           ///< threads that take the places of workers without a handler
  double idle = 0;           ///< workers: what is left of workers * wall
  double pack = 0;           ///< communication thread
  double communication = 0;  ///< communication thread, processor time; includes pack
  /// That handlers had, of workers and helpers.
  double computed() const { return compute + help; }
  template <class Archive>
  void serialize(Archive& archive) {
    archive(compute, unpack, copy, help, idle, pack, communication);
  }
};

using TrafficSummary = std::array<Volume, kTraffics>;

struct RankSummary {
  Rank rank;
  int workers = 0;
  double wall = 0;  ///< seconds of the engine's loop
  TimeSummary times;
  std::vector<double> worker_compute;  ///< seconds
  std::vector<MethodSummary> methods;  ///< those that ran here or had messages
  TrafficSummary traffic{};            ///< by Traffic
  std::vector<PeerSummary> peers;      ///< those with messages
  std::vector<std::pair<std::string, long>> network_calls;
  long collective_calls = 0;
  std::map<std::string, double> counters;
  std::uint64_t peak_rss = 0;       ///< bytes; 0: unknown, as of a simulated rank
  std::uint64_t dropped_spans = 0;  ///< spans and departures that a timeline lacks

  /// Objects that left (sent) and came (received), and their bytes.
  const Volume& migrations() const { return traffic[static_cast<std::size_t>(Traffic::migrate)]; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(rank, workers, wall, times, worker_compute, methods, traffic, peers, network_calls,
            collective_calls, counters, peak_rss, dropped_spans);
  }
};

/// What a trace does not know of its rank.
struct RunFacts {
  double wall = 0;                        ///< seconds of the engine's loop
  double communication = 0;               ///< seconds of processor time of the communication thread in it
  std::vector<std::string> method_names;  ///< by index in the registry
  std::vector<std::pair<std::string, long>> network_calls;
  long collective_calls = 0;  ///< how many of them are collective
  std::map<std::string, double> counters;
};

/// Also asks the system for this process's peak memory, unless it simulates ranks. The lanes' threads must
/// rest.
RankSummary summarize(const Trace& trace, const RunFacts& facts);

/// What a rank has sent between two of its summaries, and with how many others it has had messages.
struct Exchanged {
  std::uint64_t messages = 0, peers = 0;
};
Exchanged exchanged_between(const RankSummary& before, const RankSummary& after);

/// One counter over the ranks that have it.
struct Spread {
  double sum = 0;
  double min = 0;
  double max = 0;
};

/// Whether what was sent was received; when not, messages were lost or a rank's summary is missing.
struct Consistency {
  bool messages = true;  ///< their number, of every traffic
  bool bytes = true;     ///< their bytes, of every traffic
  bool pairs = true;     ///< both, from each rank to each
};

/// A few numbers whatever the number of ranks, and the ranks' own where they are kept.
struct RunSummary {
  int num_ranks = 0;
  int workers = 0;
  double wall = 0;  ///< seconds, the longest of the ranks'
  TimeSummary times;
  double load_imbalance = 1;  ///< most TimeSummary::computed() per worker of any rank / mean
  double idle_share = 0;      ///< 0 to 1
  double balance_saving = 0;  ///< 0 to 1: share of `wall` above computed() / workers
  std::vector<MethodSummary> methods;
  TrafficSummary traffic{};
  std::map<std::string, long> network_calls;
  long collective_calls = 0;
  std::map<std::string, Spread> counters;
  std::uint64_t peak_rss_sum = 0;  ///< bytes; 0: unknown
  std::uint64_t peak_rss_max = 0;  ///< bytes; 0: unknown
  std::uint64_t dropped_spans = 0;
  Consistency consistent;
  std::vector<RankSummary> ranks;  ///< by rank

  // What the figures above are made of.
  double most_compute = 0;  ///< seconds per worker, the largest of the ranks'
  double available = 0;     ///< workers * wall of each rank, summed
  /// Messages sent less those received, of each pair of ranks times a number of its own: all 0 where pairs
  /// agree (else only by an accident of 64 bits), in any order of summing.
  MessageCount on_the_way;

  /// "perfect balance would save 12 % of 1.3 s"
  std::string verdict() const;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(num_ranks, workers, wall, times, load_imbalance, idle_share, balance_saving, methods, traffic,
            network_calls, collective_calls, counters, peak_rss_sum, peak_rss_max, dropped_spans, consistent,
            ranks, most_compute, available, on_the_way);
  }
};

/// A run of one rank. `keep_rank`: what is the rank's own too.
RunSummary run_of(RankSummary rank, bool keep_rank);
/// A run of both's ranks.
RunSummary join(RunSummary a, RunSummary b);

/// All ranks of a run, in any order; none at all gives an empty summary.
RunSummary merge(std::vector<RankSummary> ranks);

nlohmann::ordered_json json_of(const RankSummary& summary);
nlohmann::ordered_json json_of(const RunSummary& summary);

}  // namespace weft::engine
