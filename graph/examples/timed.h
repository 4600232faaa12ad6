// What a run on the engine takes, for comparison with the plain version.
#pragma once

#include <functional>
#include <string>

#include "engine/run/runtime.h"
#include "graph/examples/example.h"

namespace weft::examples {

/// Runs `make`, which makes the objects, on all ranks; then `go`, and returns what that took. Processor time
/// is this rank's, the rest that of all, at rank 0.
Figures timed(engine::Runtime& runtime, const std::function<void(engine::Context&)>& make,
              const std::function<void(engine::Context&)>& go);

/// Sums the processor time of the ranks and prints the figures, on rank 0. All ranks must call it, without a
/// runtime.
void report(engine::Transport& transport, const std::string& program, const Options& options,
            Figures figures);

}  // namespace weft::examples
