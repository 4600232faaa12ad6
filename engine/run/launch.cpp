// Start, end, and the one message of a failure.
#include "engine/run/launch.h"

#include <cstdio>
#include <exception>
#include <string>

#include "engine/network/loopback_transport.h"
#include "engine/run/runtime.h"

namespace weft::engine {
namespace {

/// In a program of its own: what goes wrong is written, and ends all ranks if they cannot end in good order.
int run_program(Transport& transport, const std::function<int(Transport&)>& body) {
  int status = kExitFailed;
  bool broken = false;
  try {
    status = body(transport);
    // Who sees an error that others do not see must not let them wait.
    if (status != 0) transport.leave("has ended with status " + std::to_string(status));
  } catch (const RunFailure& failure) {
    broken = failure.network_broken();
    if (!broken) transport.leave(std::string("has failed: ") + failure.what());
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

/// As a guest of a program that uses MPI itself.
int run_as_guest(const std::function<int(Transport&)>& body, MpiTransportOptions options) {
  int status = kExitFailed;
  const auto leave_unless_done = [&](Transport& transport) {
    status = body(transport);
    if (status != 0) transport.leave("has ended with status " + std::to_string(status));
  };
  try {
    run_on(world_of_caller(), leave_unless_done, options);
  } catch (const RunFailure&) {  // written where it happened
    if (status == 0) status = kExitFailed;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    status = kExitFailed;
  }
  return status;
}

/// `why`, unless it has been reported, is told here where the process ends: no caller will hear of it.
void abandon_because(Transport& transport, const char* why) noexcept {
  if (why && transport.abandoning_ends_process()) {
    std::fprintf(stderr, "error: rank %d: %s\n", transport.rank().value, why);
    std::fflush(nullptr);
  }
  transport.abandon();
}

/// Of a rank whose body has thrown, which is of more interest than how the end went: `why`, null where
/// it has been reported. True when all have come.
bool close_after_failure(Transport& transport, const char* why) noexcept {
  try {
    transport.close();
    return true;
  } catch (const TransportError&) {
    abandon_because(transport, why);
    return false;
  }
}

void close_after_success(Transport& transport) {
  transport.next_phase();  // whoever has left will be missed in it
  try {
    transport.close();
  } catch (const TransportError& error) {
    abandon_because(transport, error.what());
    throw RunFailure(error.what(), false, true);
  }
  if (const auto lost = transport.lost_peer()) {
    throw RunFailure("rank " + std::to_string(lost->rank.value) + " " + lost->how, false, false);
  }
}

}  // namespace

void run_and_close(Transport& transport, const std::function<void(Transport&)>& body) {
  try {
    body(transport);
  } catch (const RunFailure& failure) {
    if (failure.network_broken()) {
      transport.abandon();
      throw;
    }
    transport.leave(std::string("has failed: ") + failure.what());
    if (close_after_failure(transport, nullptr)) throw;
    throw RunFailure(failure.what(), failure.reported_here(), true);
  } catch (const std::exception& error) {
    transport.leave(std::string("has failed: ") + error.what());
    close_after_failure(transport, error.what());
    throw;
  } catch (...) {
    transport.leave("has failed: an exception of unknown type");
    close_after_failure(transport, "an exception of unknown type");
    throw;
  }
  close_after_success(transport);
}

void run_on(CallersCommunicator communicator, const std::function<void(Transport&)>& body,
            MpiTransportOptions options) {
  MpiTransport transport(communicator, options);
  run_and_close(transport, body);
}

int launch(int argc, char** argv, const std::function<int(Transport&)>& body, MpiTransportOptions options) {
  if (mpi_is_running()) return run_as_guest(body, options);
  if (under_mpirun()) {
    MpiTransport transport(&argc, &argv, options);
    return run_program(transport, body);
  }
  LoopbackNetwork network(1, LoopbackNetwork::OnAbandon::exit);
  return run_program(network.transport(Rank(0)), body);
}

}  // namespace weft::engine
