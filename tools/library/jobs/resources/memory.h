// How much memory a run will need, how much there is, and how much was used.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "weft/weft.h"

namespace weft::tools {

/// About 2 vertices and 12 tets a unit of complexity; never less than the input, from which the run starts.
SizePrediction predict_size(double complexity, std::uint64_t input_vertices, std::uint64_t input_tets);

/// More tets than one mesh of the kernel can name, whose faces are tets times four in 32 bits: no machine
/// helps.
inline constexpr double kMaxTets = (1u << 30) - 1;
/// A subdomain may get so many times the mean's tets, and its arrays have as many slots once more for holes.
inline constexpr double kSlotsOfSubdomain = 4;

/// Bytes that the machine still has, less where a control group (a container, a batch job) allows less:
/// whoever takes more is killed. Empty when the system does not tell.
std::optional<double> memory_left();
/// What this process may take, one of the `ranks` of a run: those on this machine share what memory_left()
/// says. Less where ulimit -v, which counts for each process, or `limit` (0: none) allows less.
std::optional<double> room_of_rank(int ranks, double limit);
/// How many of a run's ranks are on this machine, as the launcher says; all of them where it does not.
int ranks_on_this_machine(int ranks);
/// The number of tasks on a node by Slurm's list for all of them, "16(x2),8" (SLURM_TASKS_PER_NODE); 0 where
/// it does not tell.
int slurm_tasks_on(const std::string& list, int node);

/// "MemAvailable" of the text of /proc/meminfo, in bytes.
std::optional<double> parse_mem_available(const std::string& meminfo);
/// A process's control group out of the text of /proc/self/cgroup: of version 2 (line "0::PATH"), or of a
/// controller of version 1 ("4:memory:PATH"). Empty where it has none.
std::string parse_cgroup_path(const std::string& text, const std::string& controller = {});
/// Bytes that the control groups of memory in `groups` (the text of /proc/self/cgroup), and those around
/// them, leave. Their figures are below `root`. Empty without a group.
std::optional<double> control_group_room(const std::filesystem::path& root, const std::string& groups);

/// A run that takes this share of what it may take ends: the result needs some room too.
inline constexpr double kMemoryInUse = 0.8;

/// The resident memory of this process.
double resident_bytes();

/// The most resident memory this process has had.
double peak_memory_bytes();

}  // namespace weft::tools
