// Who started this process.
#pragma once

namespace weft::engine {

/// True when an environment variable of this process, set by mpirun for each rank, is that of a rank which
/// started this process (a solver that calls system()): some ancestor below the launcher has the variable
/// with the same value, and an MPI library loaded. A script between mpirun and this program has none.
bool inherited_from_rank(const char* variable);

}  // namespace weft::engine
