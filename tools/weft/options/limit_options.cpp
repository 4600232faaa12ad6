// Translation of the words; the library watches.
#include "tools/weft/options/limit_options.h"

#include "tools/weft/options/option_checks.h"

namespace weft::tools {

void add_limits(CLI::App& sub, RunOptions& run) {
  sub.add_option("--time-limit", run.time_limit,
                 "end with the valid mesh that there is, written by then; exit code 1")
      ->type_name("SECONDS")
      ->check(positive_number())
      ->group("Run");
  sub.add_option("--max-memory", run.max_memory, "that each rank may take, as 8G; default: what is free here")
      ->type_name("SIZE")
      ->transform(CLI::AsSizeValue(false).description(""))
      ->group("Run");
}

}  // namespace weft::tools
