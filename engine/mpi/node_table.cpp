// The shared table by POSIX shared memory, the life of processes by /proc.
#include "engine/mpi/node_table.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>

namespace weft::engine {
namespace {

struct Process {
  char state = 0;
  std::uint64_t started = 0;  ///< clock ticks since the machine came up
};

/// From /proc/PID/stat: "PID (name) state ppid ...", the start is field 22. Nothing when there is no such
/// process.
std::optional<Process> look_up(std::int32_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  if (!std::getline(file, text)) return std::nullopt;
  const auto name_end = text.rfind(')');  // the name may hold blanks and brackets
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(text.substr(name_end + 1));
  Process process;
  fields >> process.state;
  std::string skipped;
  for (int field = 4; field < 22; ++field) fields >> skipped;
  fields >> process.started;
  return fields ? std::optional(process) : std::nullopt;
}

/// A zombie counts as gone: it will not answer.
bool lives(const NodePlace& place) {
  const auto process = look_up(place.pid.load());
  return process && process->started == place.started.load() && process->state != 'Z' &&
         process->state != 'X';
}

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

void NodeTable::Unmap::operator()(void* memory) const noexcept { munmap(memory, bytes); }

NodeTable::NodeTable(Memory memory, std::size_t lines)
    : memory_(std::move(memory)), lines_(static_cast<NodePlace*>(memory_.get()), lines) {}

NodeTable::NodeTable() : NodeTable(map(0, 1, {})) {}

NodeTable NodeTable::create(std::size_t lines, const std::string& name) {
  return map(O_CREAT | O_EXCL, lines, name);
}

NodeTable NodeTable::attach(std::size_t lines, const std::string& name) { return map(0, lines, name); }

void NodeTable::unlink(const std::string& name) noexcept { shm_unlink(name.c_str()); }

NodeTable NodeTable::map(int flags, std::size_t lines, const std::string& name) {
  const std::size_t bytes = lines * sizeof(NodePlace);
  const int file = name.empty() ? -1 : shm_open(name.c_str(), O_RDWR | O_CLOEXEC | flags, S_IRUSR | S_IWUSR);
  if (file < 0 && !name.empty()) fail("shared memory " + name + " cannot be opened");
  // posix_fallocate, not ftruncate: a full /dev/shm must be an error here, not a bus error at the first ring.
  const int full = flags & O_CREAT ? posix_fallocate(file, 0, static_cast<off_t>(bytes)) : 0;
  const int sharing = file < 0 ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_SHARED;
  void* memory = full ? MAP_FAILED : mmap(nullptr, bytes, PROT_READ | PROT_WRITE, sharing, file, 0);
  const int error = full ? full : errno;
  if (file >= 0) ::close(file);
  if (memory == MAP_FAILED) {
    errno = error;
    fail("shared memory of " + std::to_string(bytes) + " bytes cannot be mapped");
  }
  return NodeTable(Memory(memory, Unmap{bytes}), lines);
}

void NodeTable::enter(std::size_t line) {
  const auto process = look_up(getpid());
  lines_[line].started = process ? process->started : 0;
  lines_[line].pid = getpid();
}

void NodeTable::watch(std::size_t self) {
  for (std::size_t line = 0; line < lines_.size(); ++line) {
    if (line != self && lives(lines_[line])) watched_.push_back(line);
  }
}

bool NodeTable::watches(std::size_t line) const {
  return std::find(watched_.begin(), watched_.end(), line) != watched_.end();
}

std::optional<std::size_t> NodeTable::dead() const {
  for (const std::size_t line : watched_) {
    // `closed` is read again after the look: it may have closed and left in between.
    if (!lines_[line].closed && !lives(lines_[line]) && !lines_[line].closed) return line;
  }
  return std::nullopt;
}

}  // namespace weft::engine
