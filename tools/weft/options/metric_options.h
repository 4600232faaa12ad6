// The options that say where a metric comes from and what is done to it.
#pragma once

#include "weft/weft.h"

namespace CLI {
class App;
}

namespace weft::tools {

/// What is wrong where none of the sources and demands is given.
inline constexpr const char* kNoMetric =
    "no metric: give --sol FILE, --metric FILE, --metric-fn NAME (such as polar-2), --implied, --curvature "
    "N, "
    "--sagitta D or --wall REF";

/// Declares --metric and --metric-fn, which exclude each other.
void add_metric_source(CLI::App& command, MetricOptions& options);
/// Declares what makes a metric: --sol with its options, --implied, --curvature, --sagitta, --wall.
void add_metric_construction(CLI::App& command, MetricOptions& options);
/// Declares --complexity, --hmin, --hmax, --aspect, --hgrad and --hgrad-space.
void add_metric_processing(CLI::App& command, MetricOptions& options);

}  // namespace weft::tools
