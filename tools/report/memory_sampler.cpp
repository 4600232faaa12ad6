#include "tools/report/memory_sampler.h"

#include <unistd.h>

#include <fstream>
#include <new>

namespace weft::report {
namespace {

constexpr std::size_t kMostSamples = 1000;

template <class T>
void keep_every_second(std::vector<T>& list) {
  for (std::size_t i = 0; 2 * i < list.size(); ++i) list[i] = list[2 * i];
  list.resize((list.size() + 1) / 2);
}

}  // namespace

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t size = 0, resident = 0;
  if (!(statm >> size >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

MemorySampler::MemorySampler(int rank, std::chrono::milliseconds interval) : interval_(interval) {
  samples_.rank = rank;
  samples_.seconds.reserve(kMostSamples);
  samples_.bytes.reserve(kMostSamples);
  thread_ = std::thread([this] { loop(); });
}

MemorySampler::~MemorySampler() { stop(); }

MemorySamples MemorySampler::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
  return samples_;
}

/// Nobody would catch what the thread throws: its lists have their room, and where the file cannot be read
/// there is no sample.
void MemorySampler::sample() {
  std::uint64_t bytes = 0;
  try {
    bytes = resident_bytes();
  } catch (const std::bad_alloc&) {
  }
  if (bytes == 0) return;
  samples_.seconds.push_back(
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count());
  samples_.bytes.push_back(bytes);
  if (samples_.bytes.size() < kMostSamples) return;
  keep_every_second(samples_.seconds);
  keep_every_second(samples_.bytes);
  interval_ *= 2;
}

void MemorySampler::loop() {
  std::unique_lock lock(mutex_);
  do {
    sample();
  } while (!wake_.wait_for(lock, interval_, [this] { return stopped_; }));
  sample();
}

}  // namespace weft::report
