// Reads the system's limits and counters.
#include "tools/library/jobs/resources/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "meshing/metric/expectations.h"

namespace weft::tools {
namespace {

constexpr double kBytesPerTet = 250;

std::string file_text(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A file with one number; empty for "max" and for no file.
std::optional<double> file_number(const std::filesystem::path& path) {
  std::ifstream in(path);
  double value = 0;
  return in >> value ? std::optional(value) : std::nullopt;
}

/// The value of a line "NAME VALUE" or "NAME: VALUE".
std::optional<double> named_number(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string word;
    double value = 0;
    if (words >> word >> value && (word == name || word == name + ":")) return value;
  }
  return std::nullopt;
}

void lower(std::optional<double>& limit, std::optional<double> other) {
  if (other) limit = limit ? std::min(*limit, *other) : *other;
}

/// Where a version of control groups keeps its figures.
struct GroupVersion {
  const char* controller;  ///< in /proc/self/cgroup
  const char* folder;      ///< below /sys/fs/cgroup
  const char *limit, *used;
  const char* droppable;  ///< file cache, in memory.stat
};
constexpr GroupVersion kGroupVersions[] = {
    {"", "", "memory.max", "memory.current", "inactive_file"},
    {"memory", "memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"},
};

/// What one control group leaves; file cache that can be dropped is not counted as used.
std::optional<double> group_room(const std::filesystem::path& group, const GroupVersion& version) {
  const auto limit = file_number(group / version.limit), used = file_number(group / version.used);
  if (!limit || !used) return std::nullopt;
  const double droppable = named_number(file_text(group / "memory.stat"), version.droppable).value_or(0);
  return std::max(0.0, *limit - (*used - droppable));
}

std::optional<double> address_space_room() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  const double used =
      file_number("/proc/self/statm").value_or(0) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - used);
}

}  // namespace

SizePrediction predict_size(double complexity, std::uint64_t input_vertices, std::uint64_t input_tets) {
  SizePrediction size;
  size.vertices = std::max(meshing::kVerticesPerComplexity * complexity, static_cast<double>(input_vertices));
  size.tets = std::max(meshing::kTetsPerComplexity * complexity, static_cast<double>(input_tets));
  size.bytes = kBytesPerTet * size.tets;
  return size;
}

std::optional<double> parse_mem_available(const std::string& meminfo) {
  const auto kibibytes = named_number(meminfo, "MemAvailable");
  return kibibytes ? std::optional(*kibibytes * 1024) : std::nullopt;
}

std::string parse_cgroup_path(const std::string& text, const std::string& controller) {
  std::istringstream lines(text);
  std::string number, controllers, path;
  while (std::getline(lines, number, ':') && std::getline(lines, controllers, ':') &&
         std::getline(lines, path)) {
    if (("," + controllers + ",").find("," + controller + ",") != std::string::npos) return path;
  }
  return {};
}

std::optional<double> control_group_room(const std::filesystem::path& root, const std::string& groups) {
  std::optional<double> room;
  for (const GroupVersion& version : kGroupVersions) {
    const std::filesystem::path top = root / version.folder;
    std::filesystem::path group = parse_cgroup_path(groups, version.controller);
    for (; !group.empty() && group != group.parent_path(); group = group.parent_path())
      lower(room, group_room(top / group.relative_path(), version));
    lower(room, group_room(top, version));
  }
  return room;
}

std::optional<double> memory_left() {
  std::optional<double> room = parse_mem_available(file_text("/proc/meminfo"));
  lower(room, control_group_room("/sys/fs/cgroup", file_text("/proc/self/cgroup")));
  return room;
}

int slurm_tasks_on(const std::string& list, int node) {
  std::istringstream groups(list);
  std::string group;
  while (node >= 0 && std::getline(groups, group, ',')) {
    const auto times = group.find("(x");
    node -= times == std::string::npos ? 1 : std::atoi(group.c_str() + times + 2);
    if (node < 0) return std::max(0, std::atoi(group.c_str()));
  }
  return 0;
}

int ranks_on_this_machine(int ranks) {
  const auto number_of = [](const char* name) {
    const char* text = std::getenv(name);
    return text ? std::atoi(text) : 0;
  };
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS"})
    if (const int number = number_of(name); number > 0) return std::min(number, ranks);
  for (const char* name : {"SLURM_STEP_TASKS_PER_NODE", "SLURM_TASKS_PER_NODE"}) {
    const char* list = std::getenv(name);
    const int number = list ? slurm_tasks_on(list, number_of("SLURM_NODEID")) : 0;
    if (number > 0) return std::min(number, ranks);
  }
  return ranks;
}

std::optional<double> room_of_rank(int ranks, double limit) {
  std::optional<double> room = memory_left();
  if (room) *room /= ranks_on_this_machine(ranks);
  lower(room, address_space_room());
  if (limit > 0) lower(room, limit);
  return room;
}

double resident_bytes() {
  std::istringstream text(file_text("/proc/self/statm"));
  double size = 0, resident = 0;
  text >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024;
}

}  // namespace weft::tools
