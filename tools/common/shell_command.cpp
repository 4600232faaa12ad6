// posix_spawn of the shell and the wait for it.
#include "tools/common/shell_command.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "weft/data.h"

namespace weft::tools {
namespace {

using meshing::InputError;

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

/// What the child is to find: its folder, its streams, its group.
class SpawnSettings {
 public:
  SpawnSettings(const std::filesystem::path& folder, const std::filesystem::path& log) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                     0666);
    posix_spawn_file_actions_adddup2(&actions_, STDOUT_FILENO, STDERR_FILENO);
    posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes_, 0);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  pid_t start(const std::string& line) const {
    std::string shell = "sh", option = "-c", text = line;
    char* arguments[] = {shell.data(), option.data(), text.data(), nullptr};
    pid_t child = 0;
    const int error = posix_spawn(&child, "/bin/sh", &actions_, &attributes_, arguments, environ);
    if (error != 0)
      throw InputError("", "", "the shell cannot be started: " + std::string(std::strerror(error)));
    return child;
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

}  // namespace

std::string filled_in(const std::string& line, const std::map<std::string, std::string>& values) {
  std::string result;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t end = line[at] == '{' ? line.find('}', at) : std::string::npos;
    const auto value =
        end == std::string::npos ? values.end() : values.find(line.substr(at + 1, end - at - 1));
    if (value == values.end()) {
      result += line[at++];
    } else {
      result += quoted(value->second);
      at = end + 1;
    }
  }
  return result;
}

ShellResult run_shell(const std::string& line, const std::filesystem::path& folder,
                      const std::filesystem::path& log, const std::atomic<bool>& stop) {
  constexpr auto kLook = std::chrono::milliseconds(5);
  const pid_t child = SpawnSettings(folder, log).start(line);
  ShellResult result;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (stop && !result.ended) {
      result.ended = true;
      kill(-child, SIGTERM);
    }
    std::this_thread::sleep_for(kLook);
  }
  result.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return result;
}

}  // namespace weft::tools
