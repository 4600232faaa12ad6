// What a run may take: --time-limit, --max-memory.
#pragma once

#include <CLI/CLI.hpp>

#include "weft/weft.h"

namespace weft::tools {

void add_limits(CLI::App& sub, RunOptions& run);

}  // namespace weft::tools
