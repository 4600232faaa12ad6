// Validation of options: the one place that knows what each may be.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "meshing/base/error.h"
#include "meshing/cad/load_model.h"
#include "meshing/metric/metric.h"
#include "partition/decompose/partitioner.h"
#include "tools/library/api/require.h"
#include "tools/library/version.h"
#include "weft/weft.h"

namespace weft {
namespace {

/// 0 means none, as it does for every size and share that is optional.
void require_size(const char* option, double value) {
  if (value != 0) require_positive(option, value);
}

void validate(const GeometryOptions& geometry) {
  require(geometry.ridge_angle >= 0 && geometry.ridge_angle <= 180, "--ridge-angle",
          fmt::format("{} is not between 0 and 180 degrees", geometry.ridge_angle));
  require_size("--hausd", geometry.hausd);
  require(geometry.model.empty() || geometry.model == "carried" || meshing::is_model_name(geometry.model),
          "--geometry",
          fmt::format("'{}' is no CAD model by its extension, known are {}", geometry.model,
                      meshing::model_extensions()));
  require_positive("--geometry-scale", geometry.model_scale);
  require(geometry.model_scale == 1 || !geometry.model.empty(), "--geometry-scale", "requires --geometry");
}

void check_function(const std::string& name) {
  if (name.empty()) return;
  try {
    meshing::AnalyticMetric{name};
  } catch (const InputError& error) {
    throw OptionError("--metric-fn", error.what());
  }
}

void check_wall(const WallOptions& wall) {
  if (wall.refs.empty()) return;
  require(wall.height > 0 && std::isfinite(wall.height), "--wall-height", "must be given, and positive");
  require(wall.growth >= 1 && std::isfinite(wall.growth), "--wall-growth", "is below 1");
  require_size("--wall-size", wall.tangential);
}

void validate(const MetricOptions& metric) {
  check_function(metric.function);
  require(metric.norm >= 1, "--norm", fmt::format("{} is below 1", metric.norm));
  require_size("--curvature", metric.curvature);
  require_size("--sagitta", metric.sagitta);
  check_wall(metric.wall);
  require_size("--complexity", metric.complexity);
  require_size("--hmin", metric.hmin);
  require_size("--hmax", metric.hmax);
  require(metric.hmin == 0 || metric.hmax == 0 || metric.hmin <= metric.hmax, "--hmin",
          "is larger than --hmax");
  require_size("--aspect", metric.aspect);
  require(metric.aspect == 0 || metric.aspect >= 1, "--aspect", "is below 1");
  require(std::isfinite(metric.hgrad), "--hgrad", "is not a number");
}

void validate(const RunOptions& run) {
  constexpr int kMostThreads = 1024;
  require(run.threads >= 0 && run.threads <= kMostThreads, "--threads",
          fmt::format("{} is not between 1 and {}", run.threads, kMostThreads));
  require_size("--time-limit", run.time_limit);
  require_size("--max-memory", run.max_memory);
}

void check_partitioner(const DistributedOptions& distributed) {
  if (distributed.partitioner.empty()) return;
  try {
    partition::parse_partitioner(distributed.partitioner, distributed.subdomains);
  } catch (const std::invalid_argument& error) {
    throw OptionError("--partitioner", error.what());
  }
}

void validate(const CheckpointOptions& checkpoint) {
  require(checkpoint.every >= 0 && std::isfinite(checkpoint.every), "--checkpoint-every",
          fmt::format("{} is not a number of seconds", checkpoint.every));
}

void validate(const DistributedOptions& distributed) {
  constexpr std::uint32_t kMostSubdomains = 1 << 22;
  constexpr int kMostLayers = 1000;
  constexpr std::array<std::string_view, 3> kBalancers = {"stealing", "diffusion", "none"};
  require(distributed.subdomains <= kMostSubdomains, "--subdomains",
          fmt::format("{} is above {}", distributed.subdomains, kMostSubdomains));
  const int layers = distributed.layers.value_or(0);
  require(layers >= 0 && layers <= kMostLayers, "--layers",
          fmt::format("{} is not between 0 and {}", layers, kMostLayers));
  bool known = false;
  for (const std::string_view name : kBalancers) known |= name == distributed.balancer;
  require(known, "--balancer",
          fmt::format("'{}' is none of stealing, diffusion, none", distributed.balancer));
  check_partitioner(distributed);
}

}  // namespace

OptionError::OptionError(const std::string& option, const std::string& reason)
    : std::invalid_argument(option + ": " + reason), option_(option), reason_(reason) {}

bool MetricOptions::given() const {
  return !file.empty() || !function.empty() || !sol.empty() || !solutions.empty() || implied ||
         curvature > 0 || sagitta > 0 || !wall.refs.empty();
}

void validate(const Options& options) {
  validate(options.geometry);
  validate(options.metric);
  validate(options.run);
  validate(options.distributed);
  validate(options.checkpoint);
}

const char* version() { return tools::kVersion; }

}  // namespace weft
