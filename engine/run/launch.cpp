// Start, end, and the one message of a failure.
#include "engine/run/launch.h"

#include <cstdio>
#include <exception>
#include <memory>

#include "engine/mpi/mpi_transport.h"
#include "engine/network/loopback_transport.h"
#include "engine/run/runtime.h"

namespace weft::engine {
namespace {

int run(Transport& transport, const std::function<int(Transport&)>& body) {
  int status = kExitFailed;
  bool broken = false;
  try {
    status = body(transport);
  } catch (const RunFailure& failure) {
    broken = failure.network_broken();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: rank %d: %s\n", transport.rank().value, error.what());
    broken = true;
  }
  std::fflush(nullptr);
  try {
    if (!broken) transport.close();
  } catch (const TransportError& error) {  // a rank died after the run
    std::fprintf(stderr, "error: %s\n", error.what());
    broken = true;
    status = kExitFailed;
  }
  if (broken) transport.abandon();
  return status;
}

}  // namespace

int launch(int argc, char** argv, const std::function<int(Transport&)>& body) {
  if (under_mpirun()) {
    MpiTransport transport(&argc, &argv);
    return run(transport, body);
  }
  LoopbackNetwork network(1, LoopbackNetwork::OnAbandon::exit);
  return run(network.transport(Rank(0)), body);
}

}  // namespace weft::engine
