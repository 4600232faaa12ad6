// The watch over limits of time and memory.
#include "tools/library/jobs/monitor.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <optional>

#include "tools/library/jobs/resources/memory.h"

namespace weft::tools {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(50);
constexpr unsigned kTurnsOfMemory = 4;  // some files are read for it

}  // namespace

std::string text_of(EndReason reason) {
  switch (reason) {
    case EndReason::none:
      return {};
    case EndReason::interrupted:
      return "interrupted";
    case EndReason::memory_limit:
      return "memory limit";
    case EndReason::time_limit:
      return "time limit";
    case EndReason::out_of_memory:
      return "out of memory";
  }
  return {};
}

Monitor::Monitor(const RunOptions& options, int sharers, Clock::time_point begin)
    : options_(options),
      sharers_(std::max(1, sharers)),
      sharers_here_(ranks_on_this_machine(sharers_)),
      begin_(begin),
      memory_(options.max_memory) {
  memory_at_begin_ = resident_bytes();
  if (options_.time_limit > 0 || std::isfinite(memory_)) watcher_ = std::thread([this] { watch(); });
}

Monitor::~Monitor() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  over_.notify_all();
  if (watcher_.joinable()) watcher_.join();
}

void Monitor::tell(const Progress& progress) {
  if (progress.tets > tets_) tets_ = progress.tets;
  if (options_.progress && !options_.progress(progress)) cancel(EndReason::interrupted);
}

EndReason Monitor::reason() {
  if (!cancelled()) return EndReason::none;
  const EndReason reason = reason_;
  return reason == EndReason::none ? EndReason::interrupted : reason;
}

/// Who comes second has not ended the run.
void Monitor::cancel(EndReason reason) {
  if (flag().exchange(true)) return;
  reason_ = reason;
}

/// To leave the kernel, put pieces together, measure and write: about twice what a machine of the present
/// takes that has nothing else to do. Open MPI's mpirun waits for a second once or twice, by the order in
/// which the ranks end, when their exit code is not 0 (odls_base_sigkill_timeout).
double Monitor::seconds_to_finish() const {
  constexpr double kOfTet = 1e-6, kOfTetInParts = 2e-6, kAlways = 0.3, kOfLauncher = 2;
  const auto tets = static_cast<double>(tets_);
  return kAlways + (sharers_ > 1 ? kOfLauncher + kOfTetInParts * tets / sharers_ : kOfTet * tets);
}

/// Whoever takes the last memory of a machine or a control group is killed, and the mesh with it.
bool Monitor::memory_runs_out() const {
  if (memory_ > 0) return resident_bytes() > kMemoryInUse * memory_;
  const std::optional<double> left = memory_left();
  const double taken = resident_bytes() - memory_at_begin_;
  return left && *left / sharers_here_ < (1 / kMemoryInUse - 1) * taken;
}

void Monitor::watch() {
  std::unique_lock lock(mutex_);
  for (unsigned turn = 1; !over_.wait_for(lock, kPeriod, [this] { return ended_; }); ++turn) {
    const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (options_.time_limit > 0 && seconds + seconds_to_finish() >= options_.time_limit)
      cancel(EndReason::time_limit);
    if (turn % kTurnsOfMemory == 0) watch_memory();
  }
}

/// To look takes a little memory too.
void Monitor::watch_memory() {
  try {
    if (memory_runs_out()) cancel(EndReason::memory_limit);
  } catch (const std::bad_alloc&) {
    out_of_memory();
  }
}

}  // namespace weft::tools
