// The frame of the plain versions: MPI, and threads of oneTBB.
#pragma once

#include <cstdint>

#include "graph/examples/example.h"

namespace weft::examples {

/// Counts what is sent to other ranks; the figures' other parts are `run`'s business.
struct PlainRun {
  int rank = 0, ranks = 1;
  std::uint64_t tasks = 0, messages = 0, bytes = 0;

  /// As MPI_Isend, and counted; completes within wait_all(). `data` must last until then.
  void send(const void* data, std::size_t bytes, int to, int tag);
  /// As MPI_Irecv.
  void receive(void* data, std::size_t bytes, int from, int tag);
  void wait_all();
};

/// What a plain program does: makes its data, solves (which is timed), writes the result.
struct PlainProgram {
  virtual ~PlainProgram() = default;
  virtual void make(PlainRun& run) = 0;
  virtual void solve(PlainRun& run) = 0;
  virtual void write(PlainRun& run, ResultFile& file) = 0;
};

/// Starts MPI and TBB's threads, runs the program, and prints the figures. Returns the exit status.
int run_plain(int argc, char** argv, const char* name, const Options& options, PlainProgram& program);

}  // namespace weft::examples
