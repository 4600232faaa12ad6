// Everything that is known after an adaptation from files, and the judges of a result.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/library/jobs/outputs.h"
#include "weft/weft.h"

namespace weft::tools {

MeshCounts count(const meshing::MeshData& mesh);

/// What the summary and report.json are made from.
struct RunResult : Report {
  std::vector<std::string> arguments;  ///< as typed
  std::string input, metric_name;
  OutputPaths outputs;
  std::string report_path;  ///< empty: no report
};

/// Reasons to call the goal missed: ended before it was done (`ended_by`: Report::ended_by), less than half
/// of the edges unit, complexity off by more than 20 %. Without measures the first alone.
std::vector<std::string> missed_goals(const std::optional<meshing::Measures>& after, double asked_complexity,
                                      const std::string& ended_by);

/// The warning of a run that was to go on from checkpoints in a folder that has none.
std::string begun_anew(const std::string& folder);

/// How often an operator was tried, done, refused and rolled back (another thread was there).
struct OperatorTally {
  std::uint64_t tried = 0, done = 0, refused = 0, rolled_back = 0, not_needed = 0;
};
OperatorTally tally(const meshing::OperationCounts& counts, meshing::Operator op);

}  // namespace weft::tools
