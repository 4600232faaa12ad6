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
/// Some files are read to see what memory is left: not at each turn while there is plenty.
constexpr unsigned kTurnsWherePlenty = 4;

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
std::optional<double> Monitor::memory_to_take() const {
  const double resident = resident_bytes();
  if (memory_ > 0) return kMemoryInUse * memory_ - resident;
  const std::optional<double> left = memory_left();
  if (!left) return std::nullopt;
  return *left / sharers_here_ - (1 / kMemoryInUse - 1) * (resident - memory_at_begin_);
}

void Monitor::watch() {
  std::unique_lock lock(mutex_);
  for (unsigned turn = 1; !over_.wait_for(lock, kPeriod, [this] { return ended_; }); ++turn) {
    const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (options_.time_limit > 0 && seconds + seconds_to_finish() >= options_.time_limit)
      cancel(EndReason::time_limit);
    if (!plenty_ || turn % kTurnsWherePlenty == 0) watch_memory();
  }
}

/// As much as was taken since the last look may be taken before the next one (100 MB a second have been seen
/// on one thread, whose group allowed 150 MB). To look takes a little memory too.
void Monitor::watch_memory() {
  try {
    const std::optional<double> to_take = memory_to_take();
    if (!to_take) return;
    const double taken = std::max(0.0, to_take_ - *to_take);
    if (*to_take < taken) cancel(EndReason::memory_limit);
    plenty_ = *to_take > resident_bytes() - memory_at_begin_;
    to_take_ = *to_take;
  } catch (const std::bad_alloc&) {
    out_of_memory();
  }
}

}  // namespace weft::tools
