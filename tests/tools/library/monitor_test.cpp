// The watch over a limit of memory, in this process.
#include "tools/library/jobs/monitor.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <chrono>
#include <cstddef>
#include <thread>

#include "tools/library/jobs/resources/memory.h"

namespace weft::tools::monitor_test {
namespace {

using namespace std::chrono_literals;

/// So many bytes of resident memory, at once. The system fills them: sanitizers would take more for what is
/// written here.
class Taken {
 public:
  explicit Taken(std::size_t bytes)
      : bytes_(bytes),
        begin_(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1,
                    0)) {}
  ~Taken() {
    if (begin_ != MAP_FAILED) munmap(begin_, bytes_);
  }
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;

 private:
  std::size_t bytes_;
  void* begin_;
};

/// Looks for ten seconds at most.
bool is_cancelled_soon(Monitor& monitor) {
  for (int look = 0; look < 1000 && !monitor.cancelled(); ++look) std::this_thread::sleep_for(10ms);
  return monitor.cancelled();
}

TEST(Monitor, EndsARunAtTheLimitOfMemoryThatWasAskedForAndNotByABurstBelowIt) {
  constexpr double kRoom = 60e6;
  constexpr std::size_t kBurst = 40'000'000;
  RunOptions options;
  options.max_memory = (resident_bytes() + kRoom) / kMemoryInUse;
  Monitor monitor(options);
  std::this_thread::sleep_for(100ms);  // it has looked
  const Taken burst(kBurst);
  std::this_thread::sleep_for(300ms);
  EXPECT_FALSE(monitor.cancelled());
  const Taken more(kBurst);
  EXPECT_TRUE(is_cancelled_soon(monitor));
  EXPECT_EQ(monitor.reason(), EndReason::memory_limit);
}

}  // namespace
}  // namespace weft::tools::monitor_test
