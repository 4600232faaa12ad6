// Counts of the MPI calls this process has made, taken at MPI's profiling interface; needs no mpi.h.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace weft::engine {

/// Every MPI function called so far and how often, by name. Counted are all calls of the program, also those
/// of other libraries linked into it; not those inside MPI.
std::vector<std::pair<std::string, long>> mpi_calls();

/// True when all processes of some group must call the function for any to finish: the collectives of the MPI
/// standard 4.0 in the wide sense, the nonblocking, persistent and neighbourhood ones, those that make or
/// free communicators, windows and files, collective file access, window fences, and start and end of MPI
/// itself.
bool is_collective(std::string_view mpi_function_name);

}  // namespace weft::engine
