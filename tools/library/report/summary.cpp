// Tables as text.
#include "tools/library/report/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <ranges>

#include "tools/common/field_text.h"
#include "tools/common/measures_text.h"
#include "tools/common/text.h"
#include "tools/library/jobs/distributed_stats.h"
#include "tools/library/jobs/run_result.h"
#include "tools/library/report/model_text.h"

namespace weft::tools {
namespace {

using meshing::Verdict;

std::string significant(double x) { return fmt::format("{:.3g}", x); }

std::string verdict_line(const Report& run) {
  if (run.missed.empty() && !run.after) return "NOT MEASURED: whether the goal is met is not known\n";
  if (run.missed.empty() && run.complexity_asked)
    return fmt::format("GOAL MET: {} of the edges are unit, complexity {} for a target of {}\n",
                       percent(run.after->edges_unit), grouped(run.after->complexity),
                       grouped(run.target_complexity));
  if (run.missed.empty())
    return fmt::format(
        "GOAL MET: {} of the edges are unit (no --complexity was given)\n"
        "complexity {}; the metric sampled on the background mesh has {}, no target for the result\n",
        percent(run.after->edges_unit), grouped(run.after->complexity), grouped(run.target_complexity));
  std::string text;
  for (const std::string& reason : run.missed) text += "GOAL NOT MET: " + reason + "\n";
  return text;
}

/// Edges by tets, so that the shares differ a little from those of the table.
std::string left_text(const Report& run) {
  if (!run.left_as_is) return "";
  const MetricFit& fit = *run.left_as_is;
  return fmt::format(
      "the mesh fits its metric: left as it is ({} of the edges of its tets are too short, {} too long)\n",
      percent(fit.edges_short, 2), percent(fit.edges_long, 2));
}

std::string times_text(const Report& run) {
  std::string text = fmt::format("{:<28}{:>12}{:>14}{:>14}\n", "time", "seconds", "vertices", "tets");
  const auto row = [&](const std::string& name, double seconds, const std::string& vertices = "",
                       const std::string& tets = "") {
    text += fmt::format("  {:<26.26}{:>12.3f}{:>14}{:>14}", name, seconds, vertices, tets);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  };
  row("read", run.times.read);
  row("metric", run.times.metric);
  if (run.times.decompose > 0) row("decompose", run.times.decompose);
  row("adapt", run.times.adapt);
  for (const meshing::StageReport& stage : run.stages)
    row("  " + stage.name, stage.seconds, grouped(stage.vertices), grouped(stage.tets));
  row("measure", run.times.measure);
  row("  of the input", run.times.measure_input);
  if (!run.field_accounts.empty()) row("fields", run.times.fields);
  row("write", run.times.write);
  row("total", run.times.total);
  return text;
}

std::string speed_text(const Report& run) {
  if (run.left_as_is)
    return fmt::format("{} with {} thread{}; peak memory {}\n", seconds_text(run.times.adapt), run.threads,
                       run.threads == 1 ? "" : "s", bytes_text(run.peak_memory));
  const double tets = static_cast<double>(run.output_counts.tets);
  return fmt::format("{} with {} thread{}: {} tets/s; peak memory {}\n", seconds_text(run.times.adapt),
                     run.threads, run.threads == 1 ? "" : "s",
                     grouped(tets / std::max(run.times.adapt, 1e-9)), bytes_text(run.peak_memory));
}

/// The two most frequent reasons for refusal, with their shares.
std::string main_reasons(const meshing::OperationCounts& counts, meshing::Operator op,
                         std::uint64_t refused) {
  std::vector<std::pair<std::uint64_t, std::string>> reasons;
  for (std::size_t v = 0; v < meshing::kVerdictNames.size(); ++v) {
    const auto verdict = static_cast<Verdict>(v);
    if (verdict == Verdict::accepted || verdict == Verdict::not_needed || verdict == Verdict::conflict)
      continue;
    if (counts(op, verdict) > 0) reasons.emplace_back(counts(op, verdict), meshing::kVerdictNames[v]);
  }
  std::stable_sort(reasons.begin(), reasons.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(reasons.size(), 2); ++i) {
    const double share = static_cast<double>(reasons[i].first) / static_cast<double>(refused);
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", reasons[i].second, percent(share, 0));
  }
  return text;
}

std::string operations_text(const meshing::OperationCounts& counts) {
  std::string text = fmt::format("{:<12}{:>13}{:>13}{:>12}  {}\n", "operation", "tried", "done",
                                 "rolled back", "refused mainly because");
  for (std::size_t o = 0; o < meshing::kOperatorNames.size(); ++o) {
    const auto op = static_cast<meshing::Operator>(o);
    const OperatorTally t = tally(counts, op);
    if (t.tried == 0) continue;
    text += fmt::format("  {:<10}{:>13}{:>13}{:>12}  {}\n", meshing::kOperatorNames[o], grouped(t.tried),
                        grouped(t.done), grouped(t.rolled_back), main_reasons(counts, op, t.refused));
  }
  return text;
}

std::string place_text(const Point& p) { return fmt::format("({:.3g}, {:.3g}, {:.3g})", p.x, p.y, p.z); }

/// Where the metric gave way to the boundary.
std::string limit_text(const SurfaceLimit& limit) {
  if (limit.vertices == 0) return "";
  return fmt::format(
      "metric made finer at {} vertices of curved boundary (--no-surface-limit: as it is)\n"
      "  its edges were up to {} times as long as --hausd allows, at {}\n",
      grouped(limit.vertices), significant(limit.longest), place_text(limit.where));
}

/// Where boundary and metric contradict each other.
std::string surface_text(const Report& run) {
  std::string text = fmt::format("surface deviation at most {}\n", significant(run.surface_deviation));
  constexpr std::size_t kMostListed = 5;
  for (const SurfaceDemand& d : run.surface_demands | std::views::take(kMostListed))
    text += fmt::format("  {} edges of reference {} stay short: the surface allows {} at {}\n",
                        grouped(d.edges), d.ref, significant(d.allowed), place_text(d.where));
  if (run.surface_demands.size() > kMostListed)
    text += fmt::format("  and {} more references\n", run.surface_demands.size() - kMostListed);
  if (!run.surface_demands.empty())
    text += "  (a larger --hausd allows longer ones, a larger --complexity asks for short ones)\n";
  return text;
}

}  // namespace

std::string summary_text(const Report& run) {
  std::string text = verdict_line(run);
  text += left_text(run);
  text += speed_text(run) + "\n";
  text += measures_table({{"before", run.before ? &*run.before : nullptr},
                          {"after", run.after ? &*run.after : nullptr}}) +
          "\n";
  text += times_text(run) + "\n";
  if (run.distributed && !run.left_as_is) text += subdomains_text(*run.distributed) + "\n";
  if (run.checkpoints) text += checkpoints_text(*run.checkpoints) + "\n";
  if (!run.left_as_is) text += operations_text(run.operations) + "\n";
  if (!run.field_accounts.empty()) text += accounts_text(run.field_accounts, run.transfer) + "\n";
  text += limit_text(run.surface_limit);
  if (!run.left_as_is) text += surface_text(run);
  if (run.model) text += model_text(*run.model, false);
  text += mends_text(run.mends);
  for (const std::string& warning : run.warnings) text += "warning: " + warning + "\n";
  return text;
}

std::string summary_text(const FilesResult& run) {
  std::string text = fmt::format("weft adapt {} to {}\n\n", run.input, run.metric_name);
  text += summary_text(static_cast<const Report&>(run));
  text += fmt::format("mesh    {}\nmetric  {}\n", run.mesh, run.metric);
  if (!run.fields.empty()) text += fmt::format("fields  {}\n", run.fields);
  if (!run.report.empty()) text += fmt::format("report  {}\n", run.report);
  if (!run.report_error.empty()) text += fmt::format("error   {}\n", run.report_error);
  return text;
}

}  // namespace weft::tools
