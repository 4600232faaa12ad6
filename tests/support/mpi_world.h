// MPI, started once for the whole test program if mpirun started that.
#pragma once

#include "engine/network/transport.h"

namespace weft::testing {

/// Null unless under mpirun.
engine::Transport* mpi_world();

/// Ends MPI, if it runs. To be called by all ranks at the end of main().
void close_mpi_world();

}  // namespace weft::testing
