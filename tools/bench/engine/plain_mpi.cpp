// Ping-pong by bare MPI calls, in a source of its own since only few may include mpi.h.
#include "tools/bench/engine/plain_mpi.h"

#include <mpi.h>

#include <chrono>
#include <utility>

namespace weft::bench {
namespace {

/// MPI's default error handler ends the program, so that results need no checks.
void send(const std::byte* data, std::size_t size, int to) {
  MPI_Request request;
  MPI_Isend(data, static_cast<int>(size), MPI_BYTE, to, 0, MPI_COMM_WORLD, &request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
}

void receive(std::byte* data, std::size_t size, int from) {
  MPI_Request request;
  MPI_Irecv(data, static_cast<int>(size), MPI_BYTE, from, 0, MPI_COMM_WORLD, &request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
}

}  // namespace

double plain_round_trip(int rank, std::byte* a, std::byte* b, std::size_t size, int rounds) {
  const auto start = std::chrono::steady_clock::now();
  for (int round = 0; round < rounds; ++round) {
    if (rank == 0) send(a, size, 1);
    receive(b, size, 1 - rank);
    if (rank == 1) send(b, size, 0);
    std::swap(a, b);
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / rounds;
}

}  // namespace weft::bench
