// Declares the options.
#include "tools/weft/options/verbosity.h"

#include <CLI/CLI.hpp>
#include <map>

#include "tools/weft/options/option_checks.h"

namespace weft::tools {

void add_verbosity(CLI::App& command, Verbosity& verbosity, const std::string& group) {
  static const std::map<std::string, ProgressStyle> styles = {
      {"auto", ProgressStyle::automatic}, {"plain", ProgressStyle::plain}, {"none", ProgressStyle::none}};
  command
      .add_option("--progress", verbosity.progress,
                  "auto (default; a bar on a terminal, else lines), plain or none")
      ->transform(one_of(styles))
      ->type_name("STYLE")
      ->group(group);
  command.add_flag("--quiet", verbosity.quiet, "print nothing but errors; the exit code tells the outcome")
      ->group(group);
}

}  // namespace weft::tools
