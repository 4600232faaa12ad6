// One adaptation from files to files, in this process or on all ranks of the world.
#pragma once

#include "engine/simulate/simulation.h"
#include "weft/weft.h"

namespace weft::tools {

/// One mesh, in this process.
FilesResult adapt_files_as_one(const Files& files, const Options& options);

/// In subdomains, on the ranks of mpirun or in this process.
FilesResult adapt_files_in_subdomains(const Files& files, const Options& options);

/// The same on ranks that are simulated.
FilesResult adapt_files_on_simulated_ranks(const Files& files, const Options& options,
                                           const engine::SimulationOptions& simulation,
                                           engine::SimulationResult& simulated);

}  // namespace weft::tools
