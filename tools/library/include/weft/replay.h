// A recorded run on other machines: how long its task graph would take on any number of ranks, simulated with
// the real balancing, directory and end of run, and a model of the network.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "weft/weft.h"

namespace weft {

struct ReplayOptions {
  int ranks = 1;
  int threads = 1;  ///< a rank; a task takes one
  /// LATENCY,BANDWIDTH[,TOPOLOGY]: flat; tree:N, fat-tree:N for N ranks a switch; dragonfly:N for N ranks a
  /// router. fat-tree and dragonfly are simulated by SimGrid, where weft was built with it.
  std::string network = "2us,10GB/s";
  std::string balancer = "stealing";  ///< none, stealing, diffusion; rotate: moves all the time, for tests
  double slowdown = 1;                ///< of every task, 1e-6 to 1e6: cores that are all busy are slower
  bool processor_times = false;       ///< tasks take their processor time: the machine had other work, too
  int copies = 1;                     ///< so many times the recorded mesh, for weak scaling
  int split = 1;                      ///< so many times the subdomains of the mesh, each so much smaller
  double grow = 1;                    ///< so many times the tets in each subdomain, 1e-6 to 1e6
  /// Memory of a subdomain, which is sent where it moves. 0: that of the recording's processes, at most at a
  /// time, without what they had at their start, divided by its subdomains; by the profile.json that holds
  /// the graph or lies beside it. 1 MiB where none tells, as of a recording on simulated ranks.
  std::uint64_t subdomain_bytes = 0;
  std::string report;   ///< folder for replay.json, graph.json, profile.json and the page; empty: none
  std::string account;  ///< file for replay.json alone; empty: none
  std::string trace;    ///< file for a timeline; empty: none
};

/// Times are seconds of the adaptation's loop: reading, decomposition and writing are no tasks.
struct ReplayResult {
  ReplayOptions options;
  std::string network;  ///< in words
  std::uint64_t subdomains = 0, tasks = 0;
  double recorded_seconds = 0;   ///< of the recording, from the first task's begin to the last one's end
  double seconds = 0;            ///< of the replay
  double work = 0;               ///< of all tasks
  double critical_path = 0;      ///< work that cannot be done side by side
  double efficiency = 0;         ///< work / (seconds x cores)
  double idle_share = 0;         ///< of the workers' time until the end of the run was found
  double run_seconds = 0;        ///< until the end of the run was found
  double largest_subdomain = 0;  ///< work of the one that has most
  std::uint64_t messages = 0, message_bytes = 0;  ///< between ranks, of the application
  std::uint64_t packets = 0, packet_bytes = 0;    ///< on the wire, the engine's own included
  std::uint64_t migrations = 0, migrated_bytes = 0;
  std::uint64_t most_subdomains = 0;  ///< on a rank at a time
  std::uint64_t subdomain_bytes = 0;
  std::string subdomain_bytes_from;  ///< given, recorded or assumed
  std::vector<std::uint64_t>
      memory;                     ///< bytes by rank: its most subdomains at a time, each `subdomain_bytes`
  double simulation_seconds = 0;  ///< that the replay took here
  std::string report;             ///< replay.json; empty: none
  std::string json;               ///< what it has
};

/// `path`: graph.json or profile.json of a run (weft adapt --report DIR). Throws InputError, OptionError.
WEFT_API ReplayResult replay(const std::string& path, const ReplayOptions& options = {});
/// The readable account.
WEFT_API std::string summary(const ReplayResult& result);

/// Ranks that exist in this thread alone: each has a clock of its own, which goes on by the processor time
/// that the rank takes, and by the network that its messages have to pass. What they do is real.
struct SimulatedRanks {
  int ranks = 1;
  std::string network = "2us,10GB/s";  ///< as ReplayOptions::network
  double slowdown = 1;                 ///< of the processor: cores that are all busy are slower
  int cores = 0;                       ///< that threads of all ranks share; 0: one each
};

/// Times in it are those of the virtual clocks.
struct SimulatedFilesResult : FilesResult {
  SimulatedRanks on;
  double seconds = 0;                           ///< virtual, until the last rank has ended
  std::uint64_t packets = 0, packet_bytes = 0;  ///< between ranks
  double simulation_seconds = 0;                ///< that it took here
};

/// As adapt_files() in subdomains, on simulated ranks: the files are those that as many real ranks write.
/// Throws OptionError for options that are about this machine (limits of time and memory, checkpoints).
WEFT_API SimulatedFilesResult adapt_files_on(const SimulatedRanks& ranks, const Files& files,
                                             const Options& options = {});
WEFT_API std::string summary(const SimulatedFilesResult& result);

}  // namespace weft
