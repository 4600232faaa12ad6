// Preloaded into a program (LD_PRELOAD), it lets one call of a kind fail, by number: WEFT_FAULT="write:17" is
// the 17th write; "write:17:0.2" comes 0.2 s late instead. Kinds: write, to files (ENOSPC, and every later
// one, as on a full disk), read, of files (EIO), fsync, close, rename, open (for writing: ENOSPC; for
// reading: EIO), mkdir, fork, shm (shared memory), new (std::bad_alloc), map (address space: mmap of no file,
// ENOMEM), grow (mremap, and every later one), mpi (MPI_ERR_OTHER). With
// WEFT_FAULT_RANK only that rank of MPI_COMM_WORLD fails. WEFT_FAULT_COUNT names a file that gets the number
// of calls of each kind when the program ends. What is called before main() does not count. Nor do
// allocations before the first file is opened: CLI11 takes the command line apart in functions that must not
// throw.
#include <dlfcn.h>
#include <fcntl.h>
#include <mpi.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <new>

namespace {

enum Kind {
  kWrite,
  kRead,
  kFsync,
  kClose,
  kRename,
  kOpen,
  kMkdir,
  kFork,
  kShm,
  kNew,
  kMap,
  kGrow,
  kMpi,
  kKinds
};
constexpr const char* kNames[kKinds] = {"write", "read", "fsync", "close", "rename", "open", "mkdir",
                                        "fork",  "shm",  "new",   "map",   "grow",   "mpi"};

std::atomic<long> calls[kKinds];
std::atomic<bool> started{false};

/// True on the rank that is to fail; everywhere without ranks.
bool is_meant() {
  const char* wanted = std::getenv("WEFT_FAULT_RANK");
  const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");
  if (!rank) rank = std::getenv("PMI_RANK");
  return !wanted || !rank || std::strcmp(wanted, rank) == 0;
}

struct Plan {
  int kind = -1;
  long number = 0;
  double delay = 0;  ///< seconds; 0: the call fails
  Plan() {
    const char* text = std::getenv("WEFT_FAULT");
    const char* colon = text ? std::strchr(text, ':') : nullptr;
    if (!colon || !is_meant()) return;
    for (int k = 0; k < kKinds; ++k)
      if (std::strlen(kNames[k]) == static_cast<std::size_t>(colon - text) &&
          std::strncmp(text, kNames[k], static_cast<std::size_t>(colon - text)) == 0)
        kind = k;
    number = std::atol(colon + 1);
    if (const char* second = std::strchr(colon + 1, ':')) delay = std::atof(second + 1);
  }
};

const Plan& plan() {
  static const Plan made;
  return made;
}

void sleep_for(double seconds) {
  timespec left{static_cast<std::time_t>(seconds),
                static_cast<long>(1e9 * (seconds - static_cast<double>(static_cast<std::time_t>(seconds))))};
  while (::nanosleep(&left, &left) != 0 && errno == EINTR) {
  }
}

/// A full disk stays full, and so does an address space; anything else fails once.
bool fails(Kind kind) {
  if (!started || (kind == kNew && calls[kOpen] == 0)) return false;
  const long number = ++calls[kind];
  if (plan().kind != kind) return false;
  if (plan().delay > 0) {
    if (number == plan().number) sleep_for(plan().delay);
    return false;
  }
  return kind == kWrite || kind == kGrow ? number >= plan().number : number == plan().number;
}

bool is_file(int descriptor) {
  struct stat info;
  return started && ::fstat(descriptor, &info) == 0 && S_ISREG(info.st_mode);
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

struct Report {
  ~Report() {
    const char* path = std::getenv("WEFT_FAULT_COUNT");
    std::FILE* file = path && is_meant() ? std::fopen(path, "w") : nullptr;
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
  if (is_file(descriptor) && descriptor > 2 && fails(kWrite)) return errno = ENOSPC, -1;
  return real(descriptor, data, size);
}

ssize_t pwrite(int descriptor, const void* data, size_t size, off_t at) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite");
  if (fails(kWrite)) return errno = ENOSPC, -1;
  return real(descriptor, data, size, at);
}

ssize_t read(int descriptor, void* data, size_t size) {
  static const auto real = next<ssize_t (*)(int, void*, size_t)>("read");
  if (is_file(descriptor) && fails(kRead)) return errno = EIO, -1;
  return real(descriptor, data, size);
}

ssize_t pread(int descriptor, void* data, size_t size, off_t at) {
  static const auto real = next<ssize_t (*)(int, void*, size_t, off_t)>("pread");
  if (fails(kRead)) return errno = EIO, -1;
  return real(descriptor, data, size, at);
}

int fsync(int descriptor) {
  static const auto real = next<int (*)(int)>("fsync");
  if (fails(kFsync)) return errno = EIO, -1;
  return real(descriptor);
}

/// The descriptor is gone even so, as on Linux.
int close(int descriptor) {
  static const auto real = next<int (*)(int)>("close");
  const bool failed = is_file(descriptor) && fails(kClose);
  const int done = real(descriptor);
  return failed ? (errno = EIO, -1) : done;
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
  if (fails(kOpen)) return errno = flags & O_CREAT ? ENOSPC : EIO, -1;
  return real(path, flags, mode);
}

void* mmap(void* address, size_t size, int protection, int flags, int descriptor, off_t at) {
  static const auto real = next<void* (*)(void*, size_t, int, int, int, off_t)>("mmap");
  if (calls[kOpen] > 0 && flags & MAP_ANONYMOUS && fails(kMap)) return errno = ENOMEM, MAP_FAILED;
  return real(address, size, protection, flags, descriptor, at);
}

void* mremap(void* address, size_t size, size_t new_size, int flags, ...) {
  static const auto real = next<void* (*)(void*, size_t, size_t, int, ...)>("mremap");
  va_list arguments;
  va_start(arguments, flags);
  void* target = flags & MREMAP_FIXED ? va_arg(arguments, void*) : nullptr;
  va_end(arguments);
  if (new_size > size && fails(kGrow)) return errno = ENOMEM, MAP_FAILED;
  return flags & MREMAP_FIXED ? real(address, size, new_size, flags, target)
                              : real(address, size, new_size, flags);
}

int mkdir(const char* path, mode_t mode) {
  static const auto real = next<int (*)(const char*, mode_t)>("mkdir");
  if (fails(kMkdir)) return errno = ENOSPC, -1;
  return real(path, mode);
}

pid_t fork() {
  static const auto real = next<pid_t (*)()>("fork");
  if (fails(kFork)) return errno = EAGAIN, -1;
  return real();
}

int shm_open(const char* name, int flags, mode_t mode) {
  static const auto real = next<int (*)(const char*, int, mode_t)>("shm_open");
  if (fails(kShm)) return errno = ENOSPC, -1;
  return real(name, flags, mode);
}

// Those that the engine's transport calls, behind the layer that counts them (engine/mpi/).
#define WEFT_MPI_CALL(name, parameters, ...)                      \
  int P##name parameters {                                        \
    static const auto real = next<decltype(&P##name)>("P" #name); \
    return fails(kMpi) ? MPI_ERR_OTHER : real(__VA_ARGS__);       \
  }

WEFT_MPI_CALL(MPI_Isend, (const void* b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c, MPI_Request* r),
              b, n, t, to, tag, c, r)
WEFT_MPI_CALL(MPI_Irecv, (void* b, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Request* r), b,
              n, t, from, tag, c, r)
WEFT_MPI_CALL(MPI_Recv_init, (void* b, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Request* r),
              b, n, t, from, tag, c, r)
WEFT_MPI_CALL(MPI_Start, (MPI_Request * r), r)
WEFT_MPI_CALL(MPI_Test, (MPI_Request * r, int* done, MPI_Status* s), r, done, s)
WEFT_MPI_CALL(MPI_Testsome, (int n, MPI_Request* r, int* count, int* which, MPI_Status* s), n, r, count,
              which, s)
WEFT_MPI_CALL(MPI_Wait, (MPI_Request * r, MPI_Status* s), r, s)
WEFT_MPI_CALL(MPI_Cancel, (MPI_Request * r), r)
WEFT_MPI_CALL(MPI_Request_free, (MPI_Request * r), r)
WEFT_MPI_CALL(MPI_Get_count, (const MPI_Status* s, MPI_Datatype t, int* count), s, t, count)
WEFT_MPI_CALL(MPI_Init_thread, (int* n, char*** words, int wanted, int* got), n, words, wanted, got)
WEFT_MPI_CALL(MPI_Finalize, (void), )
WEFT_MPI_CALL(MPI_Comm_idup, (MPI_Comm c, MPI_Comm* copy, MPI_Request* r), c, copy, r)
WEFT_MPI_CALL(MPI_Comm_split_type, (MPI_Comm c, int type, int key, MPI_Info i, MPI_Comm* part), c, type, key,
              i, part)
WEFT_MPI_CALL(MPI_Comm_free, (MPI_Comm * c), c)
WEFT_MPI_CALL(MPI_Comm_rank, (MPI_Comm c, int* rank), c, rank)
WEFT_MPI_CALL(MPI_Comm_size, (MPI_Comm c, int* size), c, size)
WEFT_MPI_CALL(MPI_Barrier, (MPI_Comm c), c)
WEFT_MPI_CALL(MPI_Ibarrier, (MPI_Comm c, MPI_Request* r), c, r)
WEFT_MPI_CALL(MPI_Bcast, (void* b, int n, MPI_Datatype t, int root, MPI_Comm c), b, n, t, root, c)
WEFT_MPI_CALL(MPI_Allreduce, (const void* a, void* b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), a, b, n,
              t, o, c)
WEFT_MPI_CALL(MPI_Allgather,
              (const void* a, int n, MPI_Datatype t, void* b, int m, MPI_Datatype u, MPI_Comm c), a, n, t, b,
              m, u, c)
WEFT_MPI_CALL(MPI_Ialltoall,
              (const void* a, int n, MPI_Datatype t, void* b, int m, MPI_Datatype u, MPI_Comm c,
               MPI_Request* r),
              a, n, t, b, m, u, c, r)

#undef WEFT_MPI_CALL

}  // extern "C"

void* operator new(std::size_t size) {
  if (fails(kNew)) throw std::bad_alloc();
  if (void* block = std::malloc(size ? size : 1)) return block;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  if (fails(kNew)) throw std::bad_alloc();
  const auto line = static_cast<std::size_t>(alignment);
  if (void* block = std::aligned_alloc(line, (size + line) / line * line)) return block;
  throw std::bad_alloc();
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
void operator delete(void* block, std::align_val_t) noexcept { std::free(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { std::free(block); }
