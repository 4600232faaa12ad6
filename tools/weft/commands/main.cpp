// Entry of the `weft` command.
#include <string>
#include <vector>

#include "tools/weft/commands/command_line.h"

int main(int argc, char** argv) {
  return weft::tools::run_command_line(std::vector<std::string>(argv + 1, argv + argc));
}
