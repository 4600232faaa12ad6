// Tables as text.
#include "tools/weft/report/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tools/weft/jobs/subdomain_account.h"
#include "tools/weft/options/field_source.h"
#include "tools/weft/terminal/text.h"

namespace weft::tools {
namespace {

using meshing::Measures;
using meshing::Verdict;

struct MeasureRow {
  const char* name;
  std::function<std::string(const Measures&)> value;
};

std::string fixed3(double x) { return fmt::format("{:.3f}", x); }
std::string significant(double x) { return fmt::format("{:.3g}", x); }

const std::vector<MeasureRow>& measure_rows() {
  static const std::vector<MeasureRow> rows = {
      {"vertices", [](const Measures& m) { return grouped(m.num_vertices); }},
      {"tets", [](const Measures& m) { return grouped(m.num_tets); }},
      {"complexity", [](const Measures& m) { return grouped(m.complexity); }},
      {"quality  mean", [](const Measures& m) { return fixed3(m.quality_mean); }},
      {"         worst 1 % below", [](const Measures& m) { return fixed3(m.quality_q01); }},
      {"         worst 0.1 % below", [](const Measures& m) { return fixed3(m.quality_q001); }},
      {"         minimum", [](const Measures& m) { return significant(m.quality_min); }},
      {"edges    unit", [](const Measures& m) { return percent(m.edges_unit); }},
      {"         too short", [](const Measures& m) { return percent(m.edges_short); }},
      {"         too long", [](const Measures& m) { return percent(m.edges_long); }},
      {"         shortest", [](const Measures& m) { return significant(m.length_min); }},
      {"         longest", [](const Measures& m) { return significant(m.length_max); }},
  };
  return rows;
}

std::string verdict_line(const RunResult& run) {
  if (run.missed.empty() && run.asked_complexity > 0)
    return fmt::format("GOAL MET: {} of the edges are unit, complexity {} for a target of {}\n",
                       percent(run.after.edges_unit), grouped(run.after.complexity),
                       grouped(run.asked_complexity));
  if (run.missed.empty())
    return fmt::format(
        "GOAL MET: {} of the edges are unit (no --complexity was given)\n"
        "complexity {}; the metric sampled on the background mesh has {}, no target for the result\n",
        percent(run.after.edges_unit), grouped(run.after.complexity), grouped(run.target_complexity));
  std::string text;
  for (const std::string& reason : run.missed) text += "GOAL NOT MET: " + reason + "\n";
  return text;
}

std::string times_text(const RunResult& run) {
  std::string text = fmt::format("{:<28}{:>12}{:>14}{:>14}\n", "time", "seconds", "vertices", "tets");
  const auto row = [&](const std::string& name, double seconds, const std::string& vertices = "",
                       const std::string& tets = "") {
    text += fmt::format("  {:<26.26}{:>12.2f}{:>14}{:>14}", name, seconds, vertices, tets);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  };
  row("read", run.times.read);
  row("metric", run.times.metric);
  row("adapt", run.times.adapt);
  for (const meshing::StageReport& stage : run.report.stages)
    row("  " + stage.name, stage.seconds, grouped(stage.vertices), grouped(stage.tets));
  row("measure", run.times.measure);
  if (!run.field_accounts.empty()) row("fields", run.times.fields);
  row("write", run.times.write);
  row("total", run.times.total);
  return text;
}

std::string speed_text(const RunResult& run) {
  const double tets = static_cast<double>(run.after.num_tets);
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

struct Bar {
  std::string label;  ///< the lower end of its interval
  std::uint64_t count = 0;
};

/// The bins put together to at most kMostBars bars, without the empty ones at both ends.
std::vector<Bar> bars_of(const meshing::Histogram& histogram) {
  constexpr std::size_t kMostBars = 25;
  const std::size_t bins = histogram.counts.size(), step = (bins + kMostBars - 1) / kMostBars;
  std::vector<Bar> bars = {{"below", histogram.below}};
  for (std::size_t bin = 0; bin < bins; bin += step) {
    const double x =
        histogram.lo + (histogram.hi - histogram.lo) * static_cast<double>(bin) / static_cast<double>(bins);
    Bar bar{significant(histogram.logarithmic ? std::pow(10, x) : x), 0};
    for (std::size_t i = bin; i < std::min(bin + step, bins); ++i) bar.count += histogram.counts[i];
    bars.push_back(bar);
  }
  bars.push_back({"above", histogram.above});
  const auto filled = [](const Bar& bar) { return bar.count > 0; };
  bars.erase(std::find_if(bars.rbegin(), bars.rend(), filled).base(), bars.end());
  bars.erase(bars.begin(), std::find_if(bars.begin(), bars.end(), filled));
  return bars;
}

}  // namespace

std::string measures_table(const std::vector<MeasuresColumn>& columns) {
  constexpr const char* kFormat = "{:>16}";
  std::string text;
  if (columns.size() > 1) {
    text = fmt::format("{:<28}", "");
    for (const auto& [title, measures] : columns) text += fmt::format(kFormat, title);
    text += '\n';
  }
  for (const MeasureRow& row : measure_rows()) {
    text += fmt::format("  {:<26}", row.name);
    for (const auto& [title, measures] : columns)
      text += fmt::format(kFormat, measures ? row.value(*measures) : "-");
    text += '\n';
  }
  return text;
}

std::string shape_text(const meshing::ShapeMeasures& shape) {
  return fmt::format("shape: Q mean {:.3f}, 1 % {:.3f}, min {:.2g}; least dihedral angle {:.2g} degrees",
                     shape.quality_mean, shape.quality_q01, shape.quality_min, shape.least_dihedral_degrees);
}

std::string histogram_text(const std::string& title, const meshing::Histogram& histogram) {
  constexpr double kWidth = 60;
  const std::vector<Bar> bars = bars_of(histogram);
  std::uint64_t most = 1;
  for (const Bar& bar : bars) most = std::max(most, bar.count);
  std::string text = title + "\n";
  for (const Bar& bar : bars) {
    const double width = std::ceil(kWidth * static_cast<double>(bar.count) / static_cast<double>(most));
    text +=
        fmt::format("  {:>9}{:>14}  {:#<{}}\n", bar.label, grouped(bar.count), "", static_cast<int>(width));
  }
  return text;
}

std::string summary_text(const RunResult& run) {
  std::string text = fmt::format("weft adapt {} to {}\n\n", run.input, run.metric);
  text += verdict_line(run);
  text += speed_text(run) + "\n";
  text += measures_table({{"before", run.before ? &*run.before : nullptr}, {"after", &run.after}}) + "\n";
  text += times_text(run) + "\n";
  if (run.subdomains) text += subdomains_text(*run.subdomains) + "\n";
  text += operations_text(run.report.counts) + "\n";
  if (!run.field_accounts.empty()) text += accounts_text(run.field_accounts, run.transfer) + "\n";
  if (!run.subdomains)
    text += fmt::format("surface deviation at most {}\n", significant(run.report.surface_deviation));
  for (const std::string& warning : run.warnings) text += "warning: " + warning + "\n";
  text += fmt::format("mesh    {}\nmetric  {}\n", run.outputs.mesh, run.outputs.solution);
  if (!run.field_accounts.empty()) text += fmt::format("fields  {}\n", run.outputs.fields);
  if (!run.report_path.empty()) text += fmt::format("report  {}\n", run.report_path);
  return text;
}

}  // namespace weft::tools
