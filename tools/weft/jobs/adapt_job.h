// One adaptation from files to files, as `weft adapt` and every cycle of `weft loop` run it.
#pragma once

#include <string>
#include <vector>

#include "meshing/adapt/adapt.h"
#include "tools/weft/jobs/adapt_run.h"
#include "tools/weft/options/field_source.h"
#include "tools/weft/options/metric_source.h"
#include "tools/weft/terminal/progress.h"

namespace weft::tools {

struct AdaptRequest {
  std::string input, output;
  std::string background;  ///< the mesh that the metric belongs to; empty: the input
  std::string report;      ///< folder for report.json; empty: none
  bool page = true;        ///< profile.json and report.html beside it
  std::string case_name;   ///< tools/report/published.h; empty: none
  std::string graph;  ///< file for the executed graph; empty: none. Of runs in subdomains only, as `trace`
  std::string trace;  ///< file for Perfetto; empty: none
  MetricRequest metric;
  FieldRequest fields;  ///< of the input
  meshing::AdaptOptions options;
  ProgressStyle progress = ProgressStyle::automatic;
  bool force = false;                  ///< even if the memory seems too small
  std::vector<std::string> arguments;  ///< for the report
};

struct AdaptOutcome {
  int code;  ///< kDone, or kGoalNotMet with the reasons in `run`
  RunResult run;
};

/// What is known of a run before it starts.
RunResult begin_account(const AdaptRequest& request);

/// Writes mesh, metric, fields and report; ends early with the valid mesh reached so far on Ctrl-C. Throws
/// InputError where no mesh comes about, and CLI::ParseError for a request that makes no sense.
AdaptOutcome run_adapt(const AdaptRequest& request);

}  // namespace weft::tools
