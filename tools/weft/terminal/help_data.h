// The help of all subcommands as data, from which man pages, shell completion and the reference on the
// documentation's pages are made: what users read about an option is written once.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace weft::tools {

/// JSON: each command with its description, usage, options (names, placeholder, text, group), footer and
/// subcommands.
std::string help_data(const CLI::App& app);

}  // namespace weft::tools
