// Ancestors by /proc.
#include "engine/mpi/ancestry.h"

#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

namespace weft::engine {
namespace {

/// What can be read of it. (Iterators over the buffer would throw where a read fails.)
std::string read(int process, const char* file) {
  std::ifstream in("/proc/" + std::to_string(process) + "/" + file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// From "PID (name) state ppid ...".
int parent_of(int process) {
  const std::string text = read(process, "stat");
  const auto name_end = text.rfind(')');  // the name may hold blanks and brackets
  return name_end == std::string::npos || name_end + 4 > text.size() ? 0 : std::atoi(&text[name_end + 4]);
}

/// A launcher started by a rank has that rank's variables, too: what it starts are ranks of its own.
bool is_launcher(int process) {
  const std::string name = read(process, "comm");
  constexpr std::array<std::string_view, 9> kPrefixes{"mpirun", "mpiexec", "orte", "prte",      "prun",
                                                      "hydra",  "srun",    "pals", "slurmstepd"};
  for (const std::string_view prefix : kPrefixes) {
    if (name.starts_with(prefix)) return true;
  }
  return false;
}

/// The file has "name=value" after "name=value", each with a zero byte behind it.
bool has_in_environment(int process, const std::string& assignment) {
  const std::string zero(1, '\0');
  return (zero + read(process, "environ")).find(zero + assignment + zero) != std::string::npos;
}

bool has_mpi(int process) { return read(process, "maps").find("/libmpi") != std::string::npos; }

}  // namespace

bool inherited_from_rank(const char* variable) {
  const char* value = std::getenv(variable);
  if (value == nullptr) return false;
  const std::string assignment = std::string(variable) + "=" + value;
  for (int process = getppid(); process > 1; process = parent_of(process)) {
    if (is_launcher(process) || !has_in_environment(process, assignment)) return false;
    if (has_mpi(process)) return true;
  }
  return false;
}

}  // namespace weft::engine
