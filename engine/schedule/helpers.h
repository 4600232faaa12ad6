// The account of the threads that help a rank's workers.
#pragma once

#include <mutex>
#include <vector>

#include "engine/trace/trace.h"

namespace weft::engine {

/// Records in a trace how long threads of TBB's are in the slots that workers have left. They come and go as
/// TBB decides, also between runs; lanes are written during runs alone, so that they can be read afterwards.
class Helpers {
 public:
  explicit Helpers(Trace& trace)
      : trace_(trace), since_(static_cast<std::size_t>(trace.helpers()), kNobody) {}

  void begin_run();
  void end_run();
  void enters(int slot) noexcept;
  /// Whether a helper was there.
  bool leaves(int slot) noexcept;

 private:
  static constexpr TimePoint kNobody = -1;
  void record(std::size_t slot) noexcept;

  Trace& trace_;
  std::mutex mutex_;
  bool runs_ = false;
  std::vector<TimePoint> since_;  ///< by slot: when who is in it came, or the run began
};

}  // namespace weft::engine
