// Judges and counts of a run.
#include "tools/library/jobs/run_result.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "tools/common/field_text.h"
#include "tools/common/text.h"

namespace weft::tools {

using meshing::Verdict;

namespace {

using Kind = meshing::ModelEntityAccount::Kind;

/// The name of the entity whose `key` is largest.
template <class Key>
std::string worst_entity(const meshing::ModelAccount& model, const Key& key) {
  const meshing::ModelEntityAccount* worst = nullptr;
  for (const meshing::ModelEntityAccount& e : model.entities)
    if (!worst || key(e) > key(*worst)) worst = &e;
  if (!worst) return "the model";
  return fmt::format("{} {}",
                     worst->kind == Kind::node   ? "node"
                     : worst->kind == Kind::edge ? "edge"
                                                 : "face",
                     worst->id);
}

std::string off_text(const meshing::ModelAccount& m) {
  return fmt::format("{} of {} boundary vertices {} off the CAD model, by up to {:.3g} ({})", grouped(m.off),
                     grouped(m.vertices), m.off == 1 ? "is" : "are", m.largest,
                     worst_entity(m, [](const auto& e) { return e.largest - e.tolerance; }));
}

std::string turned_text(const meshing::ModelAccount& m) {
  return fmt::format("{} of {} boundary triangles {} turned against the CAD model, most of them on {}",
                     grouped(m.turned), grouped(m.triangles), m.turned == 1 ? "is" : "are",
                     worst_entity(m, [](const auto& e) { return e.turned; }));
}

}  // namespace

std::vector<std::string> worse_on_model(const meshing::ModelAccount& m) {
  constexpr double kFarther = 1.01;
  std::vector<std::string> worse;
  if (m.off > m.input.off || (m.off > 0 && m.largest > kFarther * m.input.largest))
    worse.push_back(off_text(m) +
                    fmt::format("; of the input {}, by up to {:.3g}", grouped(m.input.off), m.input.largest));
  if (m.turned > m.input.turned)
    worse.push_back(turned_text(m) + fmt::format("; of the input {}", grouped(m.input.turned)));
  return worse;
}

void warn_of_faults(const meshing::ModelAccount& m, std::vector<std::string>& warnings) {
  if (m.off > 0) warnings.push_back(off_text(m));
  if (m.turned > 0) warnings.push_back(turned_text(m));
}

MeshCounts count(const meshing::MeshData& mesh) {
  return {mesh.points.size(), mesh.tets.size(), mesh.triangles.size(), mesh.edges.size()};
}

std::vector<std::string> missed_goals(const std::optional<meshing::Measures>& after, double asked_complexity,
                                      const std::string& ended_by, const meshing::ModelAccount* model) {
  constexpr double kLeastUnitEdges = 0.5;
  constexpr double kComplexityTolerance = 0.2;
  std::vector<std::string> missed;
  if (ended_by == "interrupted" || ended_by == "out of memory")
    missed.push_back(ended_by + ": this is the valid mesh reached so far");
  else if (!ended_by.empty())
    missed.push_back("ended by its " + ended_by + ": this is the valid mesh reached so far");
  if (model)
    for (const std::string& reason : worse_on_model(*model)) missed.push_back(reason);
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

void account_for_transfer(meshing::Transfer& carried, TransferMethod asked, const std::string& from,
                          Report& report) {
  for (std::string& warning : transfer_warnings(carried, from)) report.warnings.push_back(std::move(warning));
  report.transfer = carried.method;
  report.field_accounts = std::move(carried.accounts);
  if (carried.method == asked) return;
  report.warnings.emplace_back(
      "the fields are interpolated and need not keep their integrals: the run was interrupted");
  if (report.cancelled) return;
  report.cancelled = true;
  report.ended_by = "interrupted";
  const std::vector<std::string> missed = missed_goals({}, 0, report.ended_by, nullptr);
  report.missed.insert(report.missed.begin(), missed.begin(), missed.end());
}

void warn_of_uncovered(const meshing::Uncovered& uncovered, std::uint64_t vertices,
                       std::vector<std::string>& warnings) {
  if (uncovered.vertices == 0) return;
  warnings.push_back(
      fmt::format("{} of the input's {} {} outside the background, up to {:.3g} from it: what its closest "
                  "point asks for counts there",
                  grouped(uncovered.vertices), counted(vertices, "vertex"),
                  uncovered.vertices == 1 ? "lies" : "lie", uncovered.farthest));
}

void warn_of_deviation(double deviation, double hausd, std::vector<std::string>& warnings) {
  constexpr double kFarther = 1.01;
  if (!(deviation > kFarther * hausd)) return;
  warnings.push_back(fmt::format(
      "the boundary is up to {:.3g} from its surface, farther than the {:.3g} that --hausd allows", deviation,
      hausd));
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
