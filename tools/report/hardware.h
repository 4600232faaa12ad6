// What a run ran on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace weft::report {

/// One machine and the ranks on it. The machine's name is left out on purpose: reports are passed on.
struct Hardware {
  std::vector<int> ranks;
  std::string processor;     ///< as the system calls it; empty: unknown
  int cores = 0;             ///< that this process may use
  std::uint64_t memory = 0;  ///< bytes; 0: unknown

  template <class Archive>
  void serialize(Archive& archive) {
    archive(ranks, processor, cores, memory);
  }
};

/// The machine of this process, for `rank`.
Hardware this_machine(int rank);

/// One entry for all ranks with the same hardware.
std::vector<Hardware> merge(const std::vector<Hardware>& of_ranks);

}  // namespace weft::report
