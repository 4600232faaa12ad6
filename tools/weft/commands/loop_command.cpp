// `weft loop`: a solver and adaptation in turns.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "tools/weft/commands/commands.h"
#include "tools/weft/jobs/loop.h"

namespace weft::tools {
namespace {

constexpr const char* kLoopFooter = R"(Example:
  weft loop wing.json

CONFIG is JSON; its paths are relative to its folder, where the solver runs too:
  {
    "mesh": "wing.meshb",
    "solver": "./flow {mesh} {solution} --start {restart}",
    "complexities": [10000, 20000, 40000],
    "cycles": 2,
    "metric": {"norm": 2, "hgrad": 1.5},
    "transfer": "conservative"
  }
The solver is a shell command: it reads {mesh}, writes its fields at the vertices to {solution}, may start
from {restart}, the previous solution on this mesh ('' in cycle 0), and may use the number {cycle}. All
scalar fields drive the metric. Optional: folder (default: CONFIG's name), cycles (for each complexity),
mesh_extension and solution_extension (.meshb and .solb), metric (norm, recovery, hmin, hmax, aspect,
hgrad, hgrad_space, implied, curvature, sagitta, wall...), transfer, and adapt: any other option of `weft
adapt`, with _ for - (threads, subdomains, geometry, repair, ...; checkpoint_every: an adaptation that was
killed goes on from its last checkpoint).
On a cluster start the loop itself without mpirun: "adapt": {"launcher": "mpirun -n 8"} starts each
adaptation on ranks, with one thread each unless threads says otherwise; "solver" has a launcher of its
own: "mpirun -n 64 ./flow ...".
Every cycle keeps its mesh, metric, fields, report, solution and log in its own folder, 000, 001, ...
The same command continues where an earlier run stopped, even if it was killed. Ctrl-C: exit code 1.)";

}  // namespace

void add_loop_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("loop", "alternate between a solver and adaptation to its solution");
  sub->footer(kLoopFooter);
  struct Command {
    std::string config;
    Verbosity verbosity;
  };
  auto command = std::make_shared<Command>();
  sub->add_option("CONFIG", command->config, "the configuration, .json")->type_name("FILE")->required();
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] {
    action = [command] {
      if (under_mpirun())
        throw CLI::ValidationError(
            "mpirun", "start the loop without it: adapt.launcher in CONFIG starts the adaptations on ranks");
      return run_loop(read_loop_config(command->config), command->verbosity);
    };
  });
}

}  // namespace weft::tools
