// Translation of the words; the library watches.
#include "tools/weft/options/limit_options.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "tools/common/numbers.h"
#include "tools/weft/options/option_checks.h"

namespace weft::tools {
namespace {

/// Bytes as a number without a unit.
std::string without_unit(std::string& size) {
  const std::optional<double> bytes = parse_size(size);
  if (!bytes) return "'" + size + "' is not a size, such as 8G";
  size = fmt::format("{}", *bytes);
  return {};
}

}  // namespace

void add_limits(CLI::App& sub, RunOptions& run) {
  sub.add_option("--time-limit", run.time_limit,
                 "end with the valid mesh that there is, written by then; exit code 1")
      ->type_name("SECONDS")
      ->check(positive_number())
      ->group("Run");
  sub.add_option("--max-memory", run.max_memory, "that each rank may take, as 8G; default: what is free here")
      ->type_name("SIZE")
      ->transform(CLI::Validator(without_unit, ""))
      ->group("Run");
}

}  // namespace weft::tools
