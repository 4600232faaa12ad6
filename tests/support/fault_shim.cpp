// Preloaded into a program (LD_PRELOAD), it lets one call of a kind fail, by number: WEFT_FAULT="write:17" is
// the 17th write. Kinds: write (ENOSPC, and every later one, as on a full disk), fsync (EIO), rename, open
// for writing (ENOSPC), new (std::bad_alloc). WEFT_FAULT_COUNT names a file that gets the number of calls of
// each kind when the program ends. What is called before main() does not count.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

enum Kind { kWrite, kFsync, kRename, kOpen, kNew, kKinds };
constexpr const char* kNames[kKinds] = {"write", "fsync", "rename", "open", "new"};

std::atomic<long> calls[kKinds];
std::atomic<bool> started{false};

struct Plan {
  int kind = -1;
  long number = 0;
  Plan() {
    const char* text = std::getenv("WEFT_FAULT");
    const char* colon = text ? std::strchr(text, ':') : nullptr;
    if (!colon) return;
    for (int k = 0; k < kKinds; ++k)
      if (std::strlen(kNames[k]) == static_cast<std::size_t>(colon - text) &&
          std::strncmp(text, kNames[k], static_cast<std::size_t>(colon - text)) == 0)
        kind = k;
    number = std::atol(colon + 1);
  }
};

const Plan& plan() {
  static const Plan made;
  return made;
}

/// A full disk stays full; anything else fails once.
bool fails(Kind kind) {
  if (!started) return false;
  const long number = ++calls[kind];
  if (plan().kind != kind) return false;
  return kind == kWrite ? number >= plan().number : number == plan().number;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

struct Report {
  ~Report() {
    const char* path = std::getenv("WEFT_FAULT_COUNT");
    std::FILE* file = path ? std::fopen(path, "w") : nullptr;
    if (!file) return;
    for (int k = 0; k < kKinds; ++k) std::fprintf(file, "%s %ld\n", kNames[k], calls[k].load());
    std::fclose(file);
  }
} report;

}  // namespace

extern "C" {

static int (*program)(int, char**, char**);
static int main_of_program(int argc, char** argv, char** environment) {
  started = true;
  return program(argc, argv, environment);
}

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(), void (*fini)(),
                      void (*loader_fini)(), void* stack_end) {
  using Start = int (*)(int (*)(int, char**, char**), int, char**, void (*)(), void (*)(), void (*)(), void*);
  program = main;
  return next<Start>("__libc_start_main")(main_of_program, argc, argv, init, fini, loader_fini, stack_end);
}

/// Of files alone: what goes to the terminal is not stored.
ssize_t write(int descriptor, const void* data, size_t size) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  if (descriptor > 2 && fails(kWrite)) return errno = ENOSPC, -1;
  return real(descriptor, data, size);
}

ssize_t pwrite(int descriptor, const void* data, size_t size, off_t at) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite");
  if (fails(kWrite)) return errno = ENOSPC, -1;
  return real(descriptor, data, size, at);
}

int fsync(int descriptor) {
  static const auto real = next<int (*)(int)>("fsync");
  if (fails(kFsync)) return errno = EIO, -1;
  return real(descriptor);
}

int rename(const char* from, const char* to) {
  static const auto real = next<int (*)(const char*, const char*)>("rename");
  if (fails(kRename)) return errno = EIO, -1;
  return real(from, to);
}

int open(const char* path, int flags, ...) {
  static const auto real = next<int (*)(const char*, int, ...)>("open");
  va_list arguments;
  va_start(arguments, flags);
  const unsigned mode = flags & O_CREAT ? va_arg(arguments, unsigned) : 0;
  va_end(arguments);
  if ((flags & O_CREAT) && fails(kOpen)) return errno = ENOSPC, -1;
  return real(path, flags, mode);
}

}  // extern "C"

void* operator new(std::size_t size) {
  if (fails(kNew)) throw std::bad_alloc();
  if (void* block = std::malloc(size ? size : 1)) return block;
  throw std::bad_alloc();
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
