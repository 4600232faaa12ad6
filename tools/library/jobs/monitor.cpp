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

using Seconds = std::chrono::duration<double>;

constexpr Seconds kPeriod(0.05);  ///< of looks at the clock and the caller's flag
/// Some files are read to see what memory is left: seldom while there is plenty.
constexpr Seconds kLeastPeriodOfMemory(0.005), kMostPeriodOfMemory(0.5);
/// The kernel goes on for a moment, then the mesh is measured and written.
constexpr Seconds kToLeave(0.1);
/// Where more is killed: arrays of the mesh that grow take up to so many times what it has, in one go.
constexpr double kArraysGrow = 2;
/// Bytes a second, for threads together: half a gigabyte has been seen on one.
constexpr double kFastestTaken = 2e9;

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

Monitor::Monitor(const RunOptions& options, int sharers, Clock::time_point begin, bool first)
    : options_(options),
      sharers_(std::max(1, sharers)),
      sharers_here_(ranks_on_this_machine(sharers_)),
      begin_(begin),
      first_(first),
      memory_(options.max_memory) {
  memory_at_begin_ = resident_bytes();
  hear_caller();
  if (options_.cancel || options_.time_limit > 0 || std::isfinite(memory_))
    watcher_ = std::thread([this] { watch(); });
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
  if (first_ && options_.progress && !options_.progress(progress)) cancel(EndReason::interrupted);
  hear_caller();
}

bool Monitor::cancelled() {
  hear_caller();
  return flag_.load();
}

EndReason Monitor::reason() {
  if (!cancelled()) return EndReason::none;
  const EndReason reason = reason_;
  return reason == EndReason::none ? EndReason::interrupted : reason;
}

/// Who comes second has not ended the run.
void Monitor::cancel(EndReason reason) {
  if (reason == EndReason::interrupted) caller_waits_ = true;
  if (flag_.exchange(true)) return;
  reason_ = reason;
}

void Monitor::hear_caller() {
  if (options_.cancel && options_.cancel->load()) cancel(EndReason::interrupted);
}

/// To leave the kernel, put pieces together, measure and write: about twice what a machine of the present
/// takes that has nothing else to do. Open MPI's mpirun waits for a second once or twice, by the order in
/// which the ranks end, when their exit code is not 0 (odls_base_sigkill_timeout).
double Monitor::seconds_to_finish() const {
  constexpr double kOfTet = 1e-6, kOfTetInParts = 2e-6, kAlways = 0.3, kOfLauncher = 2;
  const auto tets = static_cast<double>(tets_);
  return kAlways + seconds_of_tet_ * tets / sharers_ +
         (sharers_ > 1 ? kOfLauncher + kOfTetInParts * tets / sharers_ : kOfTet * tets);
}

/// Whoever takes the last memory of a machine or a control group is killed, and the mesh with it.
std::optional<Monitor::MemoryToTake> Monitor::memory_to_take() const {
  const double resident = resident_bytes();
  std::optional<MemoryToTake> least;
  if (memory_ > 0) least = {kMemoryInUse * memory_ - resident, true};
  const std::optional<double> left = std::isinf(memory_) ? std::nullopt : memory_left();
  if (!left) return least;
  const double share = *left / sharers_here_ - (1 / kMemoryInUse - 1) * (resident - memory_at_begin_);
  if (!least || share < least->bytes) least = {share, false};
  return least;
}

void Monitor::watch() {
  std::unique_lock lock(mutex_);
  Seconds look(0);  // at memory, after the beginning
  Seconds now = look;
  while (!over_.wait_for(lock, std::min(kPeriod, look - now), [this] { return ended_; })) {
    now = Clock::now() - begin_;
    hear_caller();
    if (options_.time_limit > 0 && now.count() + seconds_to_finish() >= options_.time_limit)
      cancel(EndReason::time_limit);
    if (now >= look) look = now + watch_memory();
  }
}

/// Returns the time to the next look: at most half of what is left can be taken until then. A limit that was
/// asked for ends the run when it is reached: to pass it by a little is not deadly, and a burst says nothing
/// of what comes after it. Of what the machine has left the run must not take more: it ends where that lasts
/// for kToLeave at the speed at which memory has been taken lately, or would not do for arrays that grow. To
/// look takes a little memory too.
Monitor::Seconds Monitor::watch_memory() {
  try {
    const std::optional<MemoryToTake> found = memory_to_take();
    if (!found) return kMostPeriodOfMemory;
    const double to_take = found->bytes;
    const Clock::time_point now = Clock::now();
    const double taken = std::max(0.0, to_take_ - to_take);
    taken_per_second_ = std::max(0.5 * taken_per_second_, taken / Seconds(now - looked_).count());
    const double held = resident_bytes() - memory_at_begin_;
    const double at_once = std::min(kArraysGrow * held, kFastestTaken * kToLeave.count());
    const double while_leaving = std::max(at_once, taken_per_second_ * kToLeave.count());
    if (to_take < (found->as_asked ? 0 : while_leaving)) cancel(EndReason::memory_limit);
    to_take_ = to_take;
    looked_ = now;
  } catch (const std::bad_alloc&) {
    out_of_memory();
  }
  return std::clamp(Seconds(0.5 * to_take_ / kFastestTaken), kLeastPeriodOfMemory, kMostPeriodOfMemory);
}

}  // namespace weft::tools
