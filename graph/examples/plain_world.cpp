// MPI as a program without a runtime uses it: its default error handler ends the program.
#include "graph/examples/plain_world.h"

#include <mpi.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <vector>

namespace weft::examples {
namespace {

std::vector<MPI_Request>& requests() {
  static std::vector<MPI_Request> all;
  return all;
}

/// Of all ranks, at rank 0.
Figures summed(const Figures& mine) {
  Figures all = mine;
  MPI_Reduce(&mine.processor, &all.processor, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  const std::uint64_t counts[3] = {mine.tasks, mine.messages, mine.bytes};
  std::uint64_t sums[3] = {};
  MPI_Reduce(counts, sums, 3, MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
  all.tasks = sums[0], all.messages = sums[1], all.bytes = sums[2];
  return all;
}

}  // namespace

void PlainRun::send(const void* data, std::size_t size, int to, int tag) {
  MPI_Isend(data, static_cast<int>(size), MPI_BYTE, to, tag, MPI_COMM_WORLD, &requests().emplace_back());
  ++messages;
  bytes += size;
}

void PlainRun::receive(void* data, std::size_t size, int from, int tag) {
  MPI_Irecv(data, static_cast<int>(size), MPI_BYTE, from, tag, MPI_COMM_WORLD, &requests().emplace_back());
}

void PlainRun::wait_all() {
  MPI_Waitall(static_cast<int>(requests().size()), requests().data(), MPI_STATUSES_IGNORE);
  requests().clear();
}

int run_plain(int argc, char** argv, const char* name, const Options& options, PlainProgram& program) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  PlainRun run;
  MPI_Comm_rank(MPI_COMM_WORLD, &run.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &run.ranks);
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(options.threads));
  tbb::task_arena arena(options.threads);
  program.make(run);
  MPI_Barrier(MPI_COMM_WORLD);
  const double wall = wall_clock(), processor = processor_seconds();
  arena.execute([&] { program.solve(run); });
  const double mine = processor_seconds() - processor;
  MPI_Barrier(MPI_COMM_WORLD);
  const Figures all = summed({wall_clock() - wall, mine, run.tasks, run.messages, run.bytes, 0});
  {
    ResultFile file(options.out);
    program.write(run, file);
  }
  if (run.rank == 0) print(name, run.ranks, options, all);
  MPI_Finalize();
  return 0;
}

}  // namespace weft::examples
