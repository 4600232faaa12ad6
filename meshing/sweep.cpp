// The crew of workers.
#include "meshing/sweep.h"

namespace weft::meshing {

Crew::Crew(Kernel& kernel, int threads, const std::atomic<bool>* interrupt)
    : kernel_(kernel), arena_(threads), interrupt_(interrupt) {
  for (int i = 0; i < threads; ++i)
    workers_.push_back(std::make_unique<Worker>(kernel, static_cast<std::uint32_t>(i) + 1, threads == 1));
}

OperationCounts Crew::take_counts() {
  OperationCounts sum;
  for (auto& w : workers_) {
    sum += w->counts;
    w->counts = {};
  }
  return sum;
}

void Crew::forget_free_slots() {
  for (auto& w : workers_) {
    w->free_tets.clear();
    w->free_vertices.clear();
  }
}

}  // namespace weft::meshing
