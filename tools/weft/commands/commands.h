// The subcommands: each declares its options on the parser and leaves behind what is to be run.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace weft::tools {

/// Set by the subcommand that the user chose; returns the exit code.
using Action = std::function<int()>;

/// `arguments` are the user's, as typed, for the report.
void add_adapt_command(CLI::App& app, Action& action, const std::vector<std::string>& arguments);
void add_stat_command(CLI::App& app, Action& action);
void add_verify_command(CLI::App& app, Action& action);
void add_metric_command(CLI::App& app, Action& action);
void add_mesh_command(CLI::App& app, Action& action);
void add_convert_command(CLI::App& app, Action& action);
void add_interpolate_command(CLI::App& app, Action& action);
void add_view_command(CLI::App& app, Action& action);
void add_graph_command(CLI::App& app, Action& action);
void add_replay_command(CLI::App& app, Action& action);
void add_report_command(CLI::App& app, Action& action);
void add_loop_command(CLI::App& app, Action& action);

/// Under mpirun, of what is not done by all ranks together; a line for stderr.
std::string done_by_first(const std::string& what);

}  // namespace weft::tools
