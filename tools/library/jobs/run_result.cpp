// Judges and counts of a run.
#include "tools/library/jobs/run_result.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/common/text.h"

namespace weft::tools {

using meshing::Verdict;

MeshCounts count(const meshing::MeshData& mesh) {
  return {mesh.points.size(), mesh.tets.size(), mesh.triangles.size(), mesh.edges.size()};
}

std::vector<std::string> missed_goals(const std::optional<meshing::Measures>& after, double asked_complexity,
                                      const std::string& ended_by) {
  constexpr double kLeastUnitEdges = 0.5;
  constexpr double kComplexityTolerance = 0.2;
  std::vector<std::string> missed;
  if (ended_by == "interrupted" || ended_by == "out of memory")
    missed.push_back(ended_by + ": this is the valid mesh reached so far");
  else if (!ended_by.empty())
    missed.push_back("ended by its " + ended_by + ": this is the valid mesh reached so far");
  if (!after) return missed;
  if (after->edges_unit < kLeastUnitEdges)
    missed.push_back(fmt::format("only {} of the edges are unit", percent(after->edges_unit)));
  // Without --complexity the target is the metric's own on the background, and a coarse background samples it
  // only roughly.
  const double off = asked_complexity > 0 ? after->complexity / asked_complexity - 1 : 0;
  if (!(std::abs(off) <= kComplexityTolerance))
    missed.push_back(fmt::format("the result's complexity {} is {} off the target {}",
                                 grouped(after->complexity), percent(std::abs(off)),
                                 grouped(asked_complexity)));
  return missed;
}

std::string begun_anew(const std::string& folder) {
  return fmt::format("{} holds no complete checkpoint: the run has begun anew", folder);
}

OperatorTally tally(const meshing::OperationCounts& counts, meshing::Operator op) {
  OperatorTally t;
  for (std::size_t v = 0; v < meshing::kVerdictNames.size(); ++v) {
    const auto verdict = static_cast<Verdict>(v);
    const std::uint64_t n = counts(op, verdict);
    (verdict == Verdict::not_needed ? t.not_needed : t.tried) += n;
    if (verdict == Verdict::accepted) t.done = n;
    if (verdict == Verdict::conflict) t.rolled_back = n;
  }
  t.refused = t.tried - t.done - t.rolled_back;
  return t;
}

}  // namespace weft::tools
