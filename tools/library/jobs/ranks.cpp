#include "tools/library/jobs/ranks.h"

#include <string>

#include "engine/mpi/mpi_transport.h"
#include "engine/network/loopback_transport.h"
#include "engine/run/launch.h"
#include "engine/run/runtime.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

/// The engine's failure as the interface's.
template <class Call>
void translating(const Call& call) {
  try {
    call();
  } catch (const engine::RunFailure& failure) {
    throw RunError(failure.what(), true);
  } catch (const engine::TransportError& error) {
    throw RunError(error.what());
  }
}

}  // namespace

void on_communicator(MPI_Comm communicator, const RankBody& body) {
  translating([&] { engine::run_on({&communicator}, body); });
}

void on_one_rank(const RankBody& body) {
  translating([&] {
    engine::LoopbackNetwork network(1);
    engine::run_and_close(network.transport(engine::Rank(0)), body);
  });
}

void on_world(const RankBody& body) {
  if (!engine::under_mpirun()) return on_one_rank(body);
  translating([&] {
    if (engine::mpi_is_running()) return engine::run_on(engine::world_of_caller(), body);
    engine::MpiTransport transport(nullptr, nullptr);
    engine::run_and_close(transport, body);
  });
}

engine::SimulationResult on_simulated_ranks(const engine::SimulationOptions& options, const RankBody& body) {
  engine::SimulationResult result;
  translating([&] { result = engine::simulate(options, body); });
  return result;
}

}  // namespace weft::tools
