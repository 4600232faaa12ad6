// The whole `weft` command as a function, so that tests can call it.
#pragma once

#include <string>
#include <vector>

namespace weft::tools {

/// Runs `weft ARGUMENTS...`; returns the exit code. Never throws: errors end as one line on stderr.
int run_command_line(const std::vector<std::string>& arguments);

}  // namespace weft::tools
