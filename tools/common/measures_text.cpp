#include "tools/common/measures_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tools/common/text.h"

namespace weft::tools {
namespace {

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

struct Bar {
  std::string label;  ///< the lower end of its interval
  std::uint64_t count = 0;
};

/// The bins put together to at most kMostBars bars, without the empty ones at both ends.
std::vector<Bar> bars_of(const Histogram& histogram) {
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

std::string shape_text(const ShapeMeasures& shape) {
  return fmt::format("shape: Q mean {:.3f}, 1 % {:.3f}, min {:.2g}; least dihedral angle {:.2g} degrees",
                     shape.quality_mean, shape.quality_q01, shape.quality_min, shape.least_dihedral_degrees);
}

std::string histogram_text(const std::string& title, const Histogram& histogram) {
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

}  // namespace weft::tools
