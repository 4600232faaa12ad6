// The pool of workers.
#include "meshing/adapt/worklist.h"

namespace weft::meshing {

WorkerPool::WorkerPool(Kernel& kernel, int threads, const std::atomic<bool>* interrupt,
                       const std::atomic<bool>* abandon)
    : kernel_(kernel), arena_(threads), interrupt_(interrupt), abandon_(abandon) {
  for (int i = 0; i < threads; ++i)
    workers_.push_back(std::make_unique<Worker>(kernel, static_cast<std::uint32_t>(i) + 1, threads == 1));
  const TetMesh& mesh = kernel.mesh;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) dead_tets_ += !mesh.alive(TetId(i));
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) dead_vertices_ += !mesh.alive(VertexId(i));
}

OperationCounts WorkerPool::take_counts() {
  OperationCounts sum;
  for (auto& w : workers_) {
    sum += w->counts;
    w->counts = {};
  }
  return sum;
}

std::uint64_t WorkerPool::live_tets() const {
  std::uint64_t free = dead_tets_;
  for (const auto& w : workers_) free += w->free_tets.size();
  return kernel_.mesh.tet_slots() - free;
}

std::uint64_t WorkerPool::live_vertices() const {
  std::uint64_t free = dead_vertices_;
  for (const auto& w : workers_) free += w->free_vertices.size();
  return kernel_.mesh.vertex_slots() - free;
}

void WorkerPool::forget_free_slots() {
  dead_tets_ = dead_vertices_ = 0;
  for (auto& w : workers_) {
    w->free_tets.clear();
    w->free_vertices.clear();
  }
}

}  // namespace weft::meshing
