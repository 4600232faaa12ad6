// Sweeps: the work lists of the kernel. A sweep visits what is marked, clears the mark and runs an operation
// on it; what another thread holds is marked again. Finished regions cost a byte a tet.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "meshing/adapt/adaptation_state.h"
#include "meshing/adapt/check_whole.h"
#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// The threads of one adaptation, with a Worker each.
class WorkerPool {
 public:
  /// The pool is interrupted when either flag, unless null, is set. `idle_threads`: see AdaptOptions.
  WorkerPool(Kernel& kernel, int threads, const std::atomic<bool>* interrupt,
             const std::atomic<bool>* abandon = nullptr, std::function<int()> idle_threads = {});

  /// Calls operation(worker, tet) -> Verdict for every live tet that has mark `mark`; returns how many were
  /// accepted.
  template <class Operation>
  std::uint64_t sweep_tets(TetMark mark, Operation operation) {
    TetMesh& mesh = kernel_.mesh;
    return sweep(mesh.tet_slots(), [&, mark](Worker& w, std::uint32_t i) {
      const TetId t(i);
      if (!mesh.take_marks(t, mark)) return false;
      const Verdict r = operation(w, t);
      if (r == Verdict::conflict && mesh.alive(t)) mesh.mark(t, mark);
      return r == Verdict::accepted;
    });
  }

  /// Calls operation(worker, vertex, its marks of these) -> Verdict for every vertex that has any of `marks`.
  template <class Operation>
  std::uint64_t sweep_vertices(std::uint8_t marks, Operation operation) {
    TetMesh& mesh = kernel_.mesh;
    return sweep(mesh.vertex_slots(), [&, marks](Worker& w, std::uint32_t i) {
      const VertexId v(i);
      const std::uint8_t taken = mesh.take_marks(v, marks);
      if (!taken) return false;
      const Verdict r = operation(w, v, taken);
      if (r == Verdict::conflict && mesh.alive(v)) mesh.mark(v, taken);
      return r == Verdict::accepted;
    });
  }

  /// The same for every live vertex, once; conflicts are not tried again.
  template <class Operation>
  std::uint64_t sweep_all_vertices(Operation operation) {
    return sweep(kernel_.mesh.vertex_slots(), [&](Worker& w, std::uint32_t i) {
      return kernel_.mesh.alive(VertexId(i)) && operation(w, VertexId(i)) == Verdict::accepted;
    });
  }

  /// During sweeps the calling thread tells `watcher` now and then which share of the sweep is done.
  void watch(std::function<void(double share)> watcher) { watcher_ = std::move(watcher); }

  /// Runs a plain function with the pool's threads at hand.
  template <class F>
  auto run(F f) {
    return arena_.execute(f);
  }

  /// Live entities now, not while a sweep runs. What lies dead in the mesh from before is counted once, when
  /// the pool is made.
  std::uint64_t live_tets() const;
  std::uint64_t live_vertices() const;
  /// Counts of all workers since the last call.
  OperationCounts take_counts();
  /// Adds free slots and counts to `state`. Not while a sweep runs.
  void save(AdaptationState& state) const;
  /// Before the first sweep, in a mesh that is the state's: each thread has its free slots again, or those of
  /// one that is not there any more.
  void restore(const AdaptationState& state);
  /// Free slots are forgotten: renumbering has closed the holes.
  void forget_free_slots();
  const AllowedOperations& allowed() const { return kernel_.policy.allowed; }
  bool interrupted() const { return is_set(interrupt_) || is_set(abandon_); }

 private:
  static constexpr std::uint32_t kGrain = 2048;

  void grow_to(std::size_t workers);

  /// Before a sweep: whether the calling thread makes it by itself, without claims.
  bool works_alone(std::uint32_t slots);

  static bool is_set(const std::atomic<bool>* flag) { return flag && flag->load(std::memory_order_relaxed); }

  template <class Visit>
  std::uint64_t sweep(std::uint32_t slots, Visit visit) {
    std::atomic<std::uint64_t> accepted{0};
    std::atomic<std::uint32_t> visited{0};
    const std::thread::id caller = std::this_thread::get_id();
    const auto body = [&](Worker& w, std::uint32_t begin, std::uint32_t end) {
      std::uint64_t mine = 0;
      for (std::uint32_t i = begin; i < end; ++i) {
        if (!visit(w, i)) continue;
        ++mine;
      }
      accepted += mine;
      visited += end - begin;
      if (watcher_ && std::this_thread::get_id() == caller)
        watcher_(static_cast<double>(visited) / static_cast<double>(slots));
    };
    if (works_alone(slots)) {
      for (std::uint32_t i = 0; i < slots && !interrupted(); i += kGrain)
        body(*workers_[0], i, std::min(slots, i + kGrain));
    } else {
      arena_.execute([&] {
        tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, slots, kGrain),
                          [&](const tbb::blocked_range<std::uint32_t>& r) {
                            if (!interrupted())
                              body(*workers_[tbb::this_task_arena::current_thread_index()], r.begin(),
                                   r.end());
                          });
      });
    }
    check_whole(kernel_.mesh, "after a pass");
    return accepted;
  }

  Kernel& kernel_;
  std::function<int()> idle_threads_;
  tbb::task_arena arena_;
  std::vector<std::unique_ptr<Worker>>
      workers_;  ///< by thread of the arena; of borrowed threads when first needed
  std::size_t threads_;
  const std::atomic<bool>* interrupt_;
  const std::atomic<bool>* abandon_;
  std::function<void(double)> watcher_;
  std::uint64_t dead_tets_ = 0, dead_vertices_ = 0;  ///< not in any worker's list
};

}  // namespace weft::meshing
