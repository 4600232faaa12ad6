// Contexts of POSIX begin, jumps go on; what the sanitizers and the C++ library keep of a thread is switched
// with them.
#undef _FORTIFY_SOURCE  // takes a jump to another stack for a mistake; before any header
#include "engine/simulate/fiber.h"

#include <cxxabi.h>
#include <setjmp.h>
#include <sys/mman.h>
#include <ucontext.h>

#include <cstdint>
#include <cstring>
#include <new>
#include <utility>

// GCC defines the former, Clang has the latter.
#if defined(__has_feature)
#define WEFT_HAS_FEATURE(feature) __has_feature(feature)
#else
#define WEFT_HAS_FEATURE(feature) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || WEFT_HAS_FEATURE(address_sanitizer)
#define WEFT_ADDRESS_SANITIZER 1
#else
#define WEFT_ADDRESS_SANITIZER 0
#endif
#if defined(__SANITIZE_THREAD__) || WEFT_HAS_FEATURE(thread_sanitizer)
#define WEFT_THREAD_SANITIZER 1
#else
#define WEFT_THREAD_SANITIZER 0
#endif

#if WEFT_ADDRESS_SANITIZER
#include <sanitizer/common_interface_defs.h>
#endif
#if WEFT_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace weft::engine {
namespace {

constexpr std::size_t kGuard = 4096;

/// A context switch sets the signal mask, by a system call that takes longer than most turns of a rank; a
/// jump does not, but sanitizers and shadow stacks know nothing of jumps to other stacks.
#if WEFT_ADDRESS_SANITIZER || WEFT_THREAD_SANITIZER || (defined(__CET__) && (__CET__ & 2))
constexpr bool kJumps = false;
#else
constexpr bool kJumps = true;
#endif

/// The exceptions that are being handled: the C++ library has one list of them a thread.
struct Handled {
  void* caught = nullptr;
  unsigned int uncaught = 0;
};

void exchange_handled(Handled& other) {
  Handled mine;
  void* globals = abi::__cxa_get_globals();
  std::memcpy(&mine, globals, sizeof mine);
  std::memcpy(globals, &other, sizeof other);
  other = mine;
}

/// One side of a switch.
struct Side {
  ucontext_t context{};
  jmp_buf place{};
  bool has_place = false;      ///< it has been left by a jump
  void* fake_stack = nullptr;  ///< of the address sanitizer
  const void* stack = nullptr;
  std::size_t stack_bytes = 0;
  void* thread = nullptr;  ///< of the thread sanitizer
};

void switch_sides([[maybe_unused]] Side& from, [[maybe_unused]] Side& to,
                  [[maybe_unused]] bool for_ever = false) {
#if WEFT_ADDRESS_SANITIZER
  __sanitizer_start_switch_fiber(for_ever ? nullptr : &from.fake_stack, to.stack, to.stack_bytes);
#endif
#if WEFT_THREAD_SANITIZER
  __tsan_switch_to_fiber(to.thread, 0);
#endif
  if constexpr (!kJumps) {
    swapcontext(&from.context, &to.context);
  } else if (_setjmp(from.place) == 0) {
    from.has_place = true;
    if (to.has_place) _longjmp(to.place, 1);
    setcontext(&to.context);
  }
#if WEFT_ADDRESS_SANITIZER
  __sanitizer_finish_switch_fiber(from.fake_stack, nullptr, nullptr);
#endif
}

}  // namespace

struct Fiber::Implementation {
  std::function<void()> function;
  Side outside, inside;
  Handled handled;  ///< of the side that does not run
  void* memory = MAP_FAILED;
  std::size_t bytes = 0;
  bool finished = false;

  static void start(unsigned int high, unsigned int low) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): makecontext() passes ints only
    auto* self = reinterpret_cast<Implementation*>(std::uintptr_t{high} << 32 | low);
#if WEFT_ADDRESS_SANITIZER
    __sanitizer_finish_switch_fiber(nullptr, &self->outside.stack, &self->outside.stack_bytes);
#endif
    self->function();
    self->finished = true;
    exchange_handled(self->handled);
    switch_sides(self->inside, self->outside, true);
  }
};

Fiber::Fiber(std::size_t stack_bytes, std::function<void()> function)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.function = std::move(function);
  self.bytes = (stack_bytes + 2 * kGuard - 1) / kGuard * kGuard;
  self.memory = mmap(nullptr, self.bytes, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_STACK, -1, 0);
  if (self.memory == MAP_FAILED) throw std::bad_alloc();
  mprotect(self.memory, kGuard, PROT_NONE);  // an overflow must not reach a neighbour
  getcontext(&self.inside.context);
  self.inside.stack = static_cast<std::byte*>(self.memory) + kGuard;
  self.inside.stack_bytes = self.bytes - kGuard;
  self.inside.context.uc_stack.ss_sp = const_cast<void*>(self.inside.stack);
  self.inside.context.uc_stack.ss_size = self.inside.stack_bytes;
#if WEFT_THREAD_SANITIZER
  self.inside.thread = __tsan_create_fiber(0);
#endif
  const auto place = reinterpret_cast<std::uintptr_t>(&self);
  makecontext(&self.inside.context, reinterpret_cast<void (*)()>(&Implementation::start), 2,
              static_cast<unsigned int>(place >> 32), static_cast<unsigned int>(place));
}

Fiber::~Fiber() {
#if WEFT_THREAD_SANITIZER
  __tsan_destroy_fiber(implementation_->inside.thread);
#endif
  munmap(implementation_->memory, implementation_->bytes);
}

void Fiber::enter() {
  Implementation& self = *implementation_;
#if WEFT_THREAD_SANITIZER
  self.outside.thread = __tsan_get_current_fiber();
#endif
  exchange_handled(self.handled);
  switch_sides(self.outside, self.inside);
}

void Fiber::leave() {
  Implementation& self = *implementation_;
  exchange_handled(self.handled);
  switch_sides(self.inside, self.outside);
}

bool Fiber::finished() const { return implementation_->finished; }

}  // namespace weft::engine
