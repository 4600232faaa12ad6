// How much memory a run will need, how much there is, and how much was used.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "weft/weft.h"

namespace weft::tools {

/// About 2 vertices and 12 tets a unit of complexity; never less than the input, from which the run starts.
SizePrediction predict_size(double complexity, std::uint64_t input_vertices, std::uint64_t input_tets);

/// More tets than 32-bit indices can name: no machine helps.
inline constexpr double kMaxTets = 4e9;

/// Bytes this process may still take: free memory of the machine, less where a control group (a container) or
/// ulimit -v allows less. Empty when the system does not tell.
std::optional<double> available_memory();

/// "MemAvailable" of the text of /proc/meminfo, in bytes.
std::optional<double> parse_mem_available(const std::string& meminfo);
/// The group's path out of the text of /proc/self/cgroup (version 2 line "0::PATH"), or empty.
std::string parse_cgroup_path(const std::string& text);

/// The most resident memory this process has had.
double peak_memory_bytes();

}  // namespace weft::tools
