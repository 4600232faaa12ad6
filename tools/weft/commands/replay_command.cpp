// `weft replay`: a recorded task graph on other numbers of cores.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>

#include "tools/weft/commands/commands.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/replay.h"

namespace weft::tools {
namespace {

constexpr const char* kReplayFooter = R"(Examples:
  weft replay run/graph.json --ranks 64 --threads 8
  weft replay run/graph.json --ranks 512 --network 50us,1GB/s,tree:16 --balancer diffusion
  weft replay run/graph.json --ranks 16 --report on-16 --trace on-16.json

FILE is the graph.json or profile.json of `weft adapt --report DIR`. The engine runs on simulated
ranks: its directory, balancing and end of run are real, tasks take the times that were recorded,
messages those of the network. Only the loop of the adaptation is replayed: reading, decomposition
and writing are not in the graph.
--copies N makes a graph of N times the mesh in as many times the subdomains, for weak scaling;
--split N one of the same mesh in N times the subdomains; --grow X makes each X times as large.
What a step takes goes with the power of the predicted tets that fits it; what is hard of a
subdomain is in few of its parts. Sizes and times of copies are drawn from the recorded ones.
--network: flat (default), tree:N (N ranks a switch), or with contention, by SimGrid, fat-tree:N and
dragonfly:N (N ranks a router).
A task takes one thread: record with --threads 1, for what other threads did at its loops is not in
its time. --processor-times is for such a recording on a machine that had other work, too.
A subdomain's memory is that of the recorded processes at most, without what they had at their start,
divided by the subdomains; it is in the profile.json beside FILE. Without one: 1 MiB.
The page, profile.json and `weft report` say that such a run was simulated; of the mesh, which is not
made, they say nothing.)";

struct ReplayCommand {
  std::string file;
  ReplayOptions options;
  Verbosity verbosity;
};

int run_replay(const ReplayCommand& command) {
  Progress progress(command.verbosity.style());
  progress.phase("replaying");
  const ReplayResult result = replay(command.file, command.options);
  progress.finish();
  command.verbosity.print("{}", summary(result));
  return kDone;
}

void add_machine(CLI::App& sub, ReplayOptions& options) {
  constexpr const char* kGroup = "Machine";
  sub.add_option("--ranks", options.ranks, "ranks (default 1)")->type_name("N")->group(kGroup);
  sub.add_option("--threads", options.threads, "threads a rank (default 1)")->type_name("N")->group(kGroup);
  sub.add_option("--network", options.network,
                 "latency, bandwidth and topology, see below; default 2us,10GB/s")
      ->type_name("L,B[,T]")
      ->group(kGroup);
  sub.add_option("--balancer", options.balancer,
                 "none, stealing (default), diffusion, or rotate, which moves all the time")
      ->type_name("NAME")
      ->group(kGroup);
  sub.add_option("--slowdown", options.slowdown, "every task takes so many times as long (default 1)")
      ->type_name("X")
      ->group(kGroup);
}

}  // namespace

void add_replay_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("replay", "simulate a recorded run on other numbers of cores");
  sub->footer(kReplayFooter);
  auto command = std::make_shared<ReplayCommand>();
  sub->add_option("FILE", command->file, "the recorded graph")->type_name("FILE")->required();
  sub->add_option("--report", command->options.report,
                  "write replay.json, graph.json, profile.json and the page to this folder")
      ->type_name("DIR");
  sub->add_option("--account", command->options.account, "write replay.json alone to this file")
      ->type_name("FILE");
  sub->add_option("--trace", command->options.trace, "write a timeline for Perfetto")->type_name("FILE");
  sub->add_option("--copies", command->options.copies, "so many times the recorded mesh (default 1)")
      ->type_name("N");
  sub->add_option("--split", command->options.split, "the mesh in so many times the subdomains (default 1)")
      ->type_name("N");
  sub->add_option("--grow", command->options.grow, "so many times the tets in each subdomain (default 1)")
      ->type_name("X");
  sub->add_flag("--processor-times", command->options.processor_times,
                "tasks take the processor time that they took, not the wall time");
  sub->add_option("--subdomain-bytes", command->options.subdomain_bytes,
                  "memory of one, sent where it moves; default: see below")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40).description(""))
      ->type_name("N");
  add_machine(*sub, command->options);
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_replay(*command); }; });
}

}  // namespace weft::tools
