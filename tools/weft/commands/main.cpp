// Entry of the `weft` command.
#include <cstdio>
#include <new>
#include <string>
#include <vector>

#include "tools/weft/commands/command_line.h"
#include "tools/weft/terminal/exit_codes.h"

int main(int argc, char** argv) {
  try {
    return weft::tools::run_command_line(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const std::bad_alloc&) {  // so early, or so late, that no subcommand is there to say it
    std::fputs("weft: out of memory\n", stderr);
    return weft::tools::kNoMesh;
  }
}
