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
};

/// True when this process was started by mpirun, srun or the like (judged by their environment variables); a
/// program that was not need not touch MPI.
bool under_mpirun();

/// The ranks of MPI_COMM_WORLD. One per process: it initialises MPI and close() finalises it. MPI is asked
/// for MPI_THREAD_FUNNELED, so the thread that constructs it is the communication thread of transport.h.
/// Throws TransportError when MPI reports an error.
class MpiTransport final : public Transport {
 public:
  /// Of all ranks together. `argc` and `argv` are main()'s, or both null.
  MpiTransport(int* argc, char*** argv, MpiTransportOptions options = {});

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

  /// Knows of the ranks of this node only.
  std::optional<Rank> dead_peer() override;

  /// Throws TransportError when a rank turns out to have died; then abandon() remains.
  void close() override;

  /// Does not return: it is MPI_Abort with exit status 2, the one way out of MPI that waits for nobody. It
  /// ends all ranks, as mpirun does anyway when one has died. Does nothing after close().
  void abandon() noexcept override;

  std::vector<std::pair<std::string, long>> calls() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace weft::engine
