#include "tools/report/hardware.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <tuple>

namespace weft::report {
namespace {

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    return colon == std::string::npos ? "" : line.substr(colon + 2);
  }
  return "";
}

int usable_cores() {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
  return static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
}

}  // namespace

Hardware this_machine(int rank) {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  const bool known = pages > 0 && page > 0;
  return {{rank},
          processor_name(),
          usable_cores(),
          known ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page) : 0};
}

std::vector<Hardware> merge(const std::vector<Hardware>& of_ranks) {
  std::vector<Hardware> kinds;
  for (const Hardware& mine : of_ranks) {
    const auto same = std::find_if(kinds.begin(), kinds.end(), [&](const Hardware& kind) {
      return std::tie(kind.processor, kind.cores, kind.memory) ==
             std::tie(mine.processor, mine.cores, mine.memory);
    });
    if (same == kinds.end())
      kinds.push_back(mine);
    else
      same->ranks.insert(same->ranks.end(), mine.ranks.begin(), mine.ranks.end());
  }
  return kinds;
}

}  // namespace weft::report
