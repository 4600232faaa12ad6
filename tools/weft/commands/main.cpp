// Entry of the `weft` command.
#include <malloc.h>

#include <cstdio>
#include <new>
#include <string>
#include <vector>

#include "tools/weft/commands/command_line.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/on_ranks.h"

namespace {

/// Large arrays that are freed go back to the system at once. By itself glibc keeps up to 32 MiB of each size
/// that it has seen, and a rank of a run in subdomains, which has many such arrays one after the other, twice
/// what it needs. Smaller ones, and what lies at the end of the heap, stay up to a size that is little beside
/// a run's: else they go and come back, page by page, which is a tenth of a run's time where pages are dear
/// (virtual machines).
void keep_few_freed_arrays() {
  mallopt(M_MMAP_THRESHOLD, 1 << 23);
  mallopt(M_TRIM_THRESHOLD, 1 << 24);
  mallopt(M_TOP_PAD, weft::place_on_ranks().ranks > 1 ? 1 << 22 : 1 << 24);
}

}  // namespace

int main(int argc, char** argv) {
  keep_few_freed_arrays();
  try {
    return weft::tools::run_command_line(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const std::bad_alloc&) {  // so early, or so late, that no subcommand is there to say it
    std::fputs("weft: out of memory\n", stderr);
    return weft::tools::kNoMesh;
  }
}
