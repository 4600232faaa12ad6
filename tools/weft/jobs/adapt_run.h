// Everything that is known after `weft adapt`: what the summary and report.json are made from.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/adapt/adapt.h"
#include "meshing/fields/transfer.h"
#include "meshing/metric/measures.h"
#include "tools/weft/jobs/memory.h"
#include "tools/weft/jobs/outputs.h"

namespace weft::tools {

struct DistributedStats;

struct StageTimes {
  double read = 0, metric = 0, adapt = 0, measure = 0, fields = 0, write = 0, total = 0;
};

struct MeshCounts {
  std::uint64_t vertices = 0, tets = 0, triangles = 0, edges = 0;
};
MeshCounts count(const meshing::MeshData& mesh);

struct RunResult {
  std::vector<std::string> arguments;  ///< as typed
  std::string input, metric;
  OutputPaths outputs;
  std::string report_path;  ///< empty: no report
  int threads = 1;
  MeshCounts input_counts, output_counts;
  double asked_complexity = 0;   ///< --complexity; 0: none was asked for
  double target_complexity = 0;  ///< else the metric's own on its background, which the result need not have
  SizePrediction predicted;
  std::optional<meshing::Measures> before;  ///< empty when the metric belongs to another mesh than the input
  meshing::Measures after;
  meshing::AdaptReport report;
  std::shared_ptr<const DistributedStats> subdomains;  ///< null: the whole mesh was adapted at once
  meshing::TransferMethod transfer = meshing::TransferMethod::linear;
  std::vector<meshing::ComponentAccount> field_accounts;  ///< empty: no fields
  StageTimes times;
  double peak_memory = 0;
  std::vector<std::string> warnings;
  std::vector<std::string> missed;  ///< why the goal was not met; empty when it was
};

/// Reasons to call the goal missed: interrupted, less than half of the edges unit, complexity off by more
/// than 20 %.
std::vector<std::string> missed_goals(const meshing::Measures& after, double asked_complexity,
                                      bool interrupted);

/// How often an operator was tried, done, refused and rolled back (another thread was there).
struct OperatorTally {
  std::uint64_t tried = 0, done = 0, refused = 0, rolled_back = 0, not_needed = 0;
};
OperatorTally tally(const meshing::OperationCounts& counts, meshing::Operator op);

}  // namespace weft::tools
