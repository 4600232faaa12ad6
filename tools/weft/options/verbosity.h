// What a command says besides its result: --quiet and --progress, the same for every subcommand.
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

#include "tools/weft/terminal/progress.h"

namespace CLI {
class App;
}

namespace weft::tools {

struct Verbosity {
  bool quiet = false;
  ProgressStyle progress = ProgressStyle::automatic;

  /// How progress is shown; not at all when quiet.
  ProgressStyle style() const { return quiet ? ProgressStyle::none : progress; }

  /// To standard output, unless quiet.
  template <class... Values>
  void print(fmt::format_string<Values...> format, Values&&... values) const {
    if (!quiet) fmt::print(format, std::forward<Values>(values)...);
  }
};

/// Declares --progress and --quiet.
void add_verbosity(CLI::App& command, Verbosity& verbosity, const std::string& group = "Options");

}  // namespace weft::tools
