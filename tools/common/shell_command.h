// Runs a line of the user's in the shell, with placeholders filled in.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <string>

namespace weft::tools {

/// `line` with every {name} of `values` replaced by its value, quoted for the shell; other braces stay.
std::string filled_in(const std::string& line, const std::map<std::string, std::string>& values);

struct ShellResult {
  int status = 0;      ///< exit status, 128 + signal for one that was killed
  bool ended = false;  ///< by `stop`
};

/// Runs `line` by /bin/sh in `folder`, its output into `log`, its input empty, in a process group of its own.
/// When `stop` becomes true the whole group is asked to end. Throws InputError when the shell cannot be
/// started.
ShellResult run_shell(const std::string& line, const std::filesystem::path& folder,
                      const std::filesystem::path& log, const std::atomic<bool>& stop);

}  // namespace weft::tools
