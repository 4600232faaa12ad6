// The shared table by POSIX shared memory, the life of processes by /proc.
#include "engine/mpi/node_table.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <string_view>
#include <system_error>

namespace weft::engine {
namespace {

struct Process {
  char state = 0;
  std::uint64_t started = 0;  ///< clock ticks since the machine came up
};

/// From "PID (name) state ppid ...", the start is field 22; all zero when that is not understood.
Process parse_stat(std::string_view text) {
  const auto name_end = text.rfind(')');  // the name may hold blanks and brackets
  if (name_end == std::string_view::npos || name_end + 2 >= text.size()) return {};
  text.remove_prefix(name_end + 2);
  Process process{text.front(), 0};
  for (int field = 3; field < 22; ++field) {
    const auto blank = text.find(' ');
    if (blank == std::string_view::npos) return {};
    text.remove_prefix(blank + 1);
  }
  std::from_chars(text.data(), text.data() + text.size(), process.started);
  return process;
}

/// /proc/PID/stat in one read; a few microseconds, for every rank of the node several times a second. Nothing
/// and ESRCH when there is no such process, nothing and another errno when that cannot be told.
std::optional<Process> look_up(std::int32_t pid) {
  const int file = open(("/proc/" + std::to_string(pid) + "/stat").c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    if (errno == ENOENT) errno = ESRCH;
    return std::nullopt;
  }
  std::array<char, 1024> text;
  const ssize_t bytes = ::read(file, text.data(), text.size());
  const int error = errno;
  ::close(file);
  errno = error;
  if (bytes <= 0) return std::nullopt;
  return parse_stat({text.data(), static_cast<std::size_t>(bytes)});
}

bool is_place_of(const Process& process, const NodePlace& place) {
  return process.started == place.started.load() && process.state != 'Z' && process.state != 'X';
}

bool is_seen(const NodePlace& place) {
  const auto process = look_up(place.pid.load());
  return process && is_place_of(*process, place);
}

/// A zombie counts as gone: it will not answer. Not to be able to look (no file descriptor is left) is no
/// sign.
bool is_gone(const NodePlace& place) {
  const auto process = look_up(place.pid.load());
  return process ? !is_place_of(*process, place) : errno == ESRCH;
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
    if (line != self && is_seen(lines_[line])) watched_.push_back(line);
  }
}

bool NodeTable::watches(std::size_t line) const {
  return std::find(watched_.begin(), watched_.end(), line) != watched_.end();
}

std::optional<std::size_t> NodeTable::dead() const {
  for (const std::size_t line : watched_) {
    // `closed` is read again after the look: it may have closed and left in between.
    if (!lines_[line].closed && is_gone(lines_[line]) && !lines_[line].closed) return line;
  }
  return std::nullopt;
}

}  // namespace weft::engine
