// Where a rank's handlers run: a oneTBB arena, shared by its workers and by the parallel loops inside
// handlers.
#pragma once

#include <functional>
#include <memory>

namespace weft::engine {

/// A task arena of `threads` slots. Workers are threads of the engine's own that enter it to run handlers;
/// slots that no worker takes are free for TBB's threads to help with a handler's loops. So a rank never
/// computes with more than `threads`, and all of them work while a single handler has work for all. Keeps
/// TBB's headers out of the others.
class Arena {
 public:
  /// A thread of TBB's takes slot 0 to threads - 1, and leaves it. Called on that thread; must not throw.
  using HelperMoves = std::function<void(int slot, bool enters)>;

  explicit Arena(int threads, HelperMoves helper_moves = {});
  ~Arena();

  /// Runs `function` inside the arena, and returns when it is done. Where all slots are taken, one of those
  /// in them runs it for this thread, which waits.
  template <class Function>
  void execute(const Function& function) {
    execute(&call<Function>, &function);
  }

  /// That of the calling thread, in an arena.
  static int slot();

  /// Runs `function`; while it waits for parallel work of its own it does nothing else, and others may help.
  template <class Function>
  static void isolate(const Function& function) {
    isolate(&call<Function>, &function);
  }

 private:
  // A handler may take less than the allocation that std::function needs.
  using Call = void (*)(const void* function);
  template <class Function>
  static void call(const void* function) {
    (*static_cast<const Function*>(function))();
  }
  void execute(Call run, const void* function);
  static void isolate(Call run, const void* function);

  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::engine
