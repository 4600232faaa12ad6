// What the subdomains of a rank have freed, given back now and then.
#pragma once

#include <atomic>
#include <chrono>

namespace weft::graph::adaptation {

/// One of a process, as its allocator is: parcels, backgrounds that have grown and subdomains that have left
/// are freed between others that stay: the allocator would keep more than half as much as is in use.
class FreedMemory {
 public:
  /// Gives it back to the system, and the blocks that are kept for messages, unless that was done so lately
  /// that it would take more than a two-hundredth of the time. From any thread.
  void give_back();

 private:
  using Clock = std::chrono::steady_clock;

  std::atomic<Clock::rep> due_ = 0;
};

}  // namespace weft::graph::adaptation
