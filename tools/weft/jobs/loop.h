// The loop of solver, metric, adaptation and transfer, and its folders.
#pragma once

#include "tools/weft/options/loop_config.h"
#include "tools/weft/options/verbosity.h"

namespace weft::tools {

/// Cycle 0 solves on the first mesh; every later one makes the metric of the last solution, adapts to it,
/// carries the solution's fields over and solves again. Each has a numbered folder:
///
///     001/mesh.meshb, mesh.solb       the adapted mesh and its metric (not in 000)
///     001/mesh-fields.solb            the last solution carried over: {restart} (not in 000; in mesh.pvtu
///                                     where that is the mesh)
///     001/report.json                 of the adaptation (not in 000)
///     001/adapt.log                   what it said, where a launcher starts it (not in 000)
///     001/solution.solb, solver.log   what the solver wrote: {solution}, and what it said
///     001/done.json                   the marker: written last, whole or not at all
///
/// cycles.csv beside the folders has a line a finished cycle. A cycle whose marker is there and whose
/// settings are still the same is kept, all from the first other one on are done again. Prints a line a
/// cycle, and the progress of each adaptation. Returns kDone, or kGoalNotMet when interrupted or when the
/// last adaptation missed its goal. Throws InputError when a cycle fails, when a kept cycle was made with
/// other settings, and when another loop, or a solver that one left behind, still runs in the folder.
int run_loop(const LoopConfig& config, const Verbosity& verbosity);

}  // namespace weft::tools
