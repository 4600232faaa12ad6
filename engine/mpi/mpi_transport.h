// Packets over MPI; ranks of one node wake each other through shared memory, so that idle ones sleep.
#pragma once

#include <cstddef>
#include <memory>

#include "engine/network/transport.h"

namespace weft::engine {

struct MpiTransportOptions {
  /// A segment longer than this travels as several MPI messages; at most 2^31 - 1, since MPI-3 counts are
  /// ints.
  std::size_t chunk_bytes = std::size_t{1} << 30;
  /// False, on all ranks: ranks of one node behave as if they were on different ones. For tests.
  bool shared_memory = true;
};

/// A communicator of a program that uses MPI itself: the address of its MPI_Comm, an intracommunicator. It
/// need only be valid while the constructor of MpiTransport runs.
struct CallersCommunicator {
  const void* mpi_comm = nullptr;
};

/// MPI runs in this process: it has been initialised and not finalised.
bool mpi_is_running();

/// MPI_COMM_WORLD, when MPI is running.
CallersCommunicator world_of_caller();

/// True when this process was started by mpirun, srun or the like as a rank (judged by their environment
/// variables, unless it has them from a rank that started it); a program that was not need not touch MPI.
bool under_mpirun();

/// The thread that constructs it is the communication thread of transport.h, the only one that calls MPI.
/// Throws TransportError when MPI reports an error.
class MpiTransport final : public Transport {
 public:
  /// The ranks of MPI_COMM_WORLD, of all ranks together. MPI is initialised here, for MPI_THREAD_FUNNELED,
  /// and finalised by close(), so there is one in the life of a process. `argc` and `argv` are main()'s, or
  /// both null.
  MpiTransport(int* argc, char*** argv, MpiTransportOptions options = {});

  /// The ranks of a communicator of the caller, of all its ranks together, any number of times. MPI must be
  /// running, at any thread level: at MPI_THREAD_SINGLE and MPI_THREAD_FUNNELED the calling thread must be
  /// MPI's main thread (the engine's other threads never call MPI). All messages go through duplicates of the
  /// communicator that report errors instead of ending the process; close() frees them. MPI is never
  /// finalised, and nothing of the caller's is changed: an error while the communicator is duplicated goes to
  /// the error handler that the caller has set for it.
  explicit MpiTransport(CallersCommunicator communicator, MpiTransportOptions options = {});

  /// Neither close() nor abandon() was called: something went wrong here, the others must not wait.
  /// abandon().
  ~MpiTransport() override;

  MpiTransport(const MpiTransport&) = delete;
  MpiTransport& operator=(const MpiTransport&) = delete;

  Rank rank() const override;
  int size() const override;
  void send(Rank to, Packet packet) override;
  bool poll(const Receive& receive) override;
  std::size_t unsent(Rank to) const override;
  void wait(std::chrono::nanoseconds at_most) override;
  void wake() noexcept override;

  /// Sees the ends of processes of this node only.
  std::optional<LostPeer> lost_peer() override;
  bool watches(Rank rank) const override;
  void leave(const std::string& why) noexcept override;
  void close() override;

  /// On MPI_COMM_WORLD it does not return: it is MPI_Abort with exit status 2, the one way out of MPI that
  /// waits for nobody. It ends all ranks, as mpirun does anyway when one has died.
  /// On a communicator of the caller it tells the other ranks, as far as they can be reached, and leaves the
  /// duplicates behind with all buffers that MPI may still read or write: leaked for good. If other ranks
  /// have died the caller's MPI_Finalize may hang; that is for the caller to decide.
  /// Does nothing after close().
  void abandon() noexcept override;
  bool abandoning_ends_process() const override;

  std::vector<std::pair<std::string, long>> calls() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace weft::engine
