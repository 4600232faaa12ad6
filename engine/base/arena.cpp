// The door to oneTBB's arenas.
#include "engine/base/arena.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_scheduler_observer.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace weft::engine {
namespace {

// TBB caps the threads of the whole process at its number of cores, and the smallest of several controls
// counts. Every arena needs its own threads even so: on a machine with fewer cores they share them. The cap
// only grows: lowering it while arenas ask for threads is asking for trouble, and threads without work cost
// nothing.
class ThreadBudget {
 public:
  static void change(int threads) {
    static ThreadBudget budget;
    const std::lock_guard lock(budget.mutex_);
    budget.threads_ += threads;
    const auto cores = static_cast<std::size_t>(std::max(1u, std::thread::hardware_concurrency()));
    const std::size_t wanted =
        std::max(cores, static_cast<std::size_t>(budget.threads_)) + 1;  // and a main thread
    if (wanted <= budget.cap_) return;
    budget.cap_ = wanted;
    budget.control_ =
        std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, budget.cap_);
  }

 private:
  std::mutex mutex_;
  int threads_ = 0;
  std::size_t cap_ = 0;
  std::unique_ptr<tbb::global_control> control_;
};

/// Passes on who comes and goes besides the threads that enter an arena by themselves.
class Observer : public tbb::task_scheduler_observer {
 public:
  Observer(tbb::task_arena& arena, Arena::HelperMoves helper_moves)
      : tbb::task_scheduler_observer(arena), helper_moves_(std::move(helper_moves)) {
    if (helper_moves_) observe(true);
  }
  ~Observer() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override { tell(is_worker, true); }
  void on_scheduler_exit(bool is_worker) override { tell(is_worker, false); }

 private:
  void tell(bool is_worker, bool enters) {
    if (is_worker) helper_moves_(tbb::this_task_arena::current_thread_index(), enters);
  }
  const Arena::HelperMoves helper_moves_;
};

}  // namespace

struct Arena::Implementation {
  Implementation(int threads, HelperMoves helper_moves)
      : arena(threads, /*reserved_for_masters=*/1), count(threads) {
    ThreadBudget::change(count);
    arena.initialize();
    observer.emplace(arena, std::move(helper_moves));
  }
  ~Implementation() {
    observer.reset();
    arena.terminate();
    ThreadBudget::change(-count);
  }
  tbb::task_arena arena;
  int count;
  std::optional<Observer> observer;
};

Arena::Arena(int threads, HelperMoves helper_moves)
    : implementation_(std::make_unique<Implementation>(threads, std::move(helper_moves))) {}
Arena::~Arena() = default;

void Arena::execute(Call run, const void* function) {
  implementation_->arena.execute([=] { run(function); });
}

int Arena::slot() { return tbb::this_task_arena::current_thread_index(); }

void Arena::isolate(Call run, const void* function) {
  tbb::this_task_arena::isolate([=] { run(function); });
}

}  // namespace weft::engine
