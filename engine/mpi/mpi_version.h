// Which MPI this program has.
#pragma once

#include <string>

namespace weft::engine {

/// Name and version of the library, in one line, and of the standard; may be called before MPI is
/// initialised.
std::string mpi_version();

}  // namespace weft::engine
