// Everything that is known after an adaptation from files, and the judges of a result.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "meshing/fields/coverage.h"
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
/// of the edges unit, complexity off by more than 20 %, farther from the CAD model than the input
/// (worse_on_model()). Without measures the first and the last alone. `model` may be null.
std::vector<std::string> missed_goals(const std::optional<meshing::Measures>& after, double asked_complexity,
                                      const std::string& ended_by, const meshing::ModelAccount* model);

/// What became of fields that were carried to the result from the mesh called `from`: accounts (taken from
/// `carried`), warnings, and the end of the run where that was what cut `asked` short.
void account_for_transfer(meshing::Transfer& carried, TransferMethod asked, const std::string& from,
                          Report& report);

/// Adds how many of an input's vertices lie outside the mesh that the metric belongs to.
void warn_of_uncovered(const meshing::Uncovered& uncovered, std::uint64_t vertices,
                       std::vector<std::string>& warnings);

/// In which respects a result lies on the CAD model worse than its input did: more vertices off it, or
/// farther off, or more triangles turned against it. Empty for what the input had and could not be mended.
std::vector<std::string> worse_on_model(const meshing::ModelAccount& model);

/// Adds how many vertices are off the model and how many triangles turned against it, how far and where.
void warn_of_faults(const meshing::ModelAccount& model, std::vector<std::string>& warnings);

/// Adds that the boundary is farther from its reconstructed surface than was wanted at most, where it is.
void warn_of_deviation(double deviation, double hausd, std::vector<std::string>& warnings);

/// The warning of a run that was to go on from checkpoints in a folder that has none.
std::string begun_anew(const std::string& folder);

/// How often an operator was tried, done, refused and rolled back (another thread was there).
struct OperatorTally {
  std::uint64_t tried = 0, done = 0, refused = 0, rolled_back = 0, not_needed = 0;
};
OperatorTally tally(const meshing::OperationCounts& counts, meshing::Operator op);

}  // namespace weft::tools
