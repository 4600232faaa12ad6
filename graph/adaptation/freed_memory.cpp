// One thread gives back what all have freed.
#include "graph/adaptation/freed_memory.h"

#include <limits>

#include "engine/base/blob_pool.h"
#include "meshing/base/freed_memory.h"

namespace weft::graph::adaptation {

void FreedMemory::give_back() {
  constexpr Clock::rep kPause = 200;  // times what it takes
  const Clock::rep begin = Clock::now().time_since_epoch().count();
  Clock::rep due = due_.load(std::memory_order_relaxed);
  if (begin < due) return;
  // Nobody else until it is done.
  if (!due_.compare_exchange_strong(due, std::numeric_limits<Clock::rep>::max(), std::memory_order_relaxed))
    return;
  engine::give_back_freed_blobs();
  meshing::give_back_freed_memory();
  const Clock::rep end = Clock::now().time_since_epoch().count();
  due_.store(end + kPause * (end - begin), std::memory_order_relaxed);
}

}  // namespace weft::graph::adaptation
