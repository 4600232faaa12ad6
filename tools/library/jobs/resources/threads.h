// The threads that a call may use, without telling the rest of the process.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <optional>
#include <thread>

namespace weft::tools {

/// The number that `threads` means: 0 is all cores.
inline int number_of_threads(int threads) {
  return threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// Runs call() where TBB's loops use at most `threads` threads. More than there are cores must be allowed to
/// the whole process while it lasts; fewer are a matter of this arena alone.
template <class Call>
auto with_threads(int threads, const Call& call) {
  std::optional<tbb::global_control> more;
  if (threads > number_of_threads(0))
    more.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute(call);
}

}  // namespace weft::tools
