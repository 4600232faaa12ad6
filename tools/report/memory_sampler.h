// How much memory this process has in use, looked at now and then.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "tools/report/profile.h"

namespace weft::report {

/// Samples from its construction until stop(). When there are 1,000 samples every second one goes and the
/// interval doubles, so any run leaves 500 to 1,000. Costs a few microseconds a sample.
class MemorySampler {
 public:
  explicit MemorySampler(int rank, std::chrono::milliseconds interval = std::chrono::milliseconds(20));
  ~MemorySampler();
  MemorySampler(const MemorySampler&) = delete;
  MemorySampler& operator=(const MemorySampler&) = delete;

  /// Ends the sampling. Empty where the system does not tell.
  MemorySamples stop();

 private:
  void sample();
  void loop();

  std::chrono::milliseconds interval_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  MemorySamples samples_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopped_ = false;
  std::thread thread_;
};

/// Resident bytes of this process now; 0: unknown.
std::uint64_t resident_bytes();

}  // namespace weft::report
