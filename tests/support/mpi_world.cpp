// The process's one MPI transport.
#include "tests/support/mpi_world.h"

#include <memory>

#include "engine/mpi/mpi_transport.h"

namespace weft::testing {
namespace {

std::unique_ptr<engine::MpiTransport>& world() {
  // Segments in chunks of a prime size, so that every large message of the tests takes the path of huge ones.
  static std::unique_ptr<engine::MpiTransport> transport =
      engine::under_mpirun() ? std::make_unique<engine::MpiTransport>(
                                   nullptr, nullptr, engine::MpiTransportOptions{.chunk_bytes = 65537})
                             : nullptr;
  return transport;
}

}  // namespace

engine::Transport* mpi_world() { return world().get(); }

void close_mpi_world() {
  if (world()) world()->close();
  world().reset();
}

}  // namespace weft::testing
