// The pool of workers.
#include "meshing/adapt/worklist.h"

#include <utility>

namespace weft::meshing {

WorkerPool::WorkerPool(Kernel& kernel, int threads, const std::atomic<bool>* interrupt,
                       const std::atomic<bool>* abandon, std::function<int()> idle_threads)
    : kernel_(kernel),
      idle_threads_(std::move(idle_threads)),
      arena_(threads),
      threads_(static_cast<std::size_t>(threads)),
      interrupt_(interrupt),
      abandon_(abandon) {
  if (idle_threads_ && threads > 1) {
    arena_.initialize(tbb::attach());
    threads_ = static_cast<std::size_t>(arena_.max_concurrency());
  }
  grow_to(idle_threads_ ? 1 : threads_);
  const TetMesh& mesh = kernel.mesh;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) dead_tets_ += !mesh.alive(TetId(i));
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) dead_vertices_ += !mesh.alive(VertexId(i));
}

void WorkerPool::grow_to(std::size_t workers) {
  while (workers_.size() < workers) {
    const auto owner = static_cast<std::uint32_t>(workers_.size()) + 1;
    workers_.push_back(std::make_unique<Worker>(kernel_, owner, threads_ == 1));
  }
}

bool WorkerPool::works_alone(std::uint32_t slots) {
  if (threads_ == 1) return true;
  const bool alone = idle_threads_ && (slots <= kGrain || idle_threads_() == 0);
  if (!alone) grow_to(threads_);
  for (auto& worker : workers_) worker->claims.work_alone(alone);
  return alone;
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

void WorkerPool::save(AdaptationState& state) const {
  for (const auto& w : workers_) {
    state.workers.push_back(w->free_tets.size());
    state.workers.push_back(w->free_vertices.size());
    for (const TetId t : w->free_tets) state.free_tets.push_back(t.value);
    for (const VertexId v : w->free_vertices) state.free_vertices.push_back(v.value);
    state.counts += w->counts;
  }
}

void WorkerPool::restore(const AdaptationState& state) {
  auto tet = state.free_tets.begin();
  auto vertex = state.free_vertices.begin();
  for (std::size_t i = 0; i + 1 < state.workers.size(); i += 2) {
    Worker& w = *workers_[i / 2 % workers_.size()];
    for (std::uint64_t n = state.workers[i]; n > 0; --n) w.free_tets.push_back(TetId(*tet++));
    for (std::uint64_t n = state.workers[i + 1]; n > 0; --n) w.free_vertices.push_back(VertexId(*vertex++));
  }
  workers_[0]->counts += state.counts;
  dead_tets_ -= state.free_tets.size();
  dead_vertices_ -= state.free_vertices.size();
}

void WorkerPool::forget_free_slots() {
  dead_tets_ = dead_vertices_ = 0;
  for (auto& w : workers_) {
    w->free_tets.clear();
    w->free_vertices.clear();
  }
}

}  // namespace weft::meshing
