// Benchmarks of the engine, one a run: mpirun -n N weft_engine_bench latency|rate|migration|balance POLICY|
// trace|idle. Figures as JSON on rank 0's standard output.
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

#include "engine/json/json.h"
#include "engine/run/launch.h"
#include "tools/bench/engine/benches.h"

namespace weft::bench {
namespace {

constexpr const char* kUsage = "weft_engine_bench latency|rate|migration|balance POLICY|trace|idle\n";

/// Benchmarks between two ranks need exactly these.
int ranks_for(const std::string& name) {
  if (name == "latency" || name == "rate" || name == "migration") return 2;
  return name == "trace" ? 1 : 0;
}

ordered_json figures(engine::Transport& transport, const std::string& name, const std::string& policy) {
  if (name == "latency") return latency(transport);
  if (name == "rate") return rate(transport);
  if (name == "migration") return migration(transport);
  if (name == "balance") return balance(transport, policy);
  if (name == "trace") return trace(transport);
  return idle(transport);
}

bool known(const std::string& name, bool has_policy) {
  if (name == "balance") return has_policy;
  return !has_policy && (ranks_for(name) > 0 || name == "idle");
}

int run(engine::Transport& transport, std::span<char*> arguments) {
  const bool speaks = transport.rank() == engine::Rank(0);
  const std::string name = arguments.size() > 1 ? arguments[1] : "";
  if (arguments.size() > 3 || !known(name, arguments.size() > 2)) {
    if (speaks) std::fputs(kUsage, stderr);
    return EXIT_FAILURE;
  }
  if (const int ranks = ranks_for(name); ranks > 0 && transport.size() != ranks) {
    if (speaks) std::fprintf(stderr, "weft_engine_bench %s: runs on %d rank(s)\n", name.c_str(), ranks);
    return EXIT_FAILURE;
  }
  const ordered_json result = figures(transport, name, arguments.size() > 2 ? arguments[2] : "");
  if (speaks) std::printf("%s\n", result.dump(2).c_str());
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::engine::launch(argc, argv, [&](weft::engine::Transport& transport) {
    return weft::bench::run(transport, {argv, static_cast<std::size_t>(argc)});
  });
}
