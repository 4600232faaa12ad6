#include "meshing/io/files/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <exception>

namespace weft::meshing {
namespace {

/// What the child writes before its error text: a child that writes nothing has not come to the end.
constexpr char kDone = '!';

/// What went wrong, if anything.
std::string issue_of(const std::function<std::string()>& work) try {
  return work();
} catch (const std::exception& error) {
  return error.what();
}

/// Whoever started this process, or it itself, may have other plans for these: here crashes and alarms end
/// it. Who interrupts the parent does not mean that the data are damaged: the child goes on, and ends with
/// it.
void end_by_signals() {
  sigset_t none;
  ::sigemptyset(&none);
  for (const int s : {SIGALRM, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) ::signal(s, SIG_DFL);
  for (const int s : {SIGINT, SIGTERM, SIGHUP}) ::signal(s, SIG_IGN);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
}

[[noreturn]] void be_child(const std::function<std::string()>& work, int to_parent, unsigned patience) {
  const int nowhere = ::open("/dev/null", O_WRONLY);
  if (nowhere >= 0)
    for (const int output : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, output);
  end_by_signals();
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::alarm(patience);
  const std::string words = kDone + issue_of(work);
  for (std::size_t at = 0; at < words.size();) {
    const ssize_t count = ::write(to_parent, words.data() + at, words.size() - at);
    if (count < 0 && errno != EINTR) ::_exit(1);
    if (count > 0) at += static_cast<std::size_t>(count);
  }
  ::_exit(0);
}

std::string everything_from(int descriptor) {
  std::string words;
  std::array<char, 512> block{};
  for (;;) {
    const ssize_t count = ::read(descriptor, block.data(), block.size());
    if (count == 0 || (count < 0 && errno != EINTR)) return words;
    if (count > 0) words.append(block.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

std::optional<std::string> issue_of_child(const std::function<std::string()>& work, unsigned patience) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return issue_of(work);
  const pid_t child = ::fork();
  if (child == 0) be_child(work, ends[1], patience);
  ::close(ends[1]);
  const std::string words = child < 0 ? "" : everything_from(ends[0]);
  ::close(ends[0]);
  if (child < 0) return issue_of(work);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (words.empty()) return std::nullopt;
  return words.substr(1);
}

}  // namespace weft::meshing
