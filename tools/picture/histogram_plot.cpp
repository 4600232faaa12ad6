// Four panels on one sheet.
#include "tools/picture/histogram_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "tools/picture/axis_scale.h"

namespace weft::picture {
namespace {

using meshing::Histogram;
using meshing::Measures;

constexpr int kWidth = 1800, kHeight = 1300;
constexpr double kFont = 27;

/// One plot: the rectangle of its axes, what it shows.
struct Panel {
  double x, y, width, height;
  std::string title;
  const Histogram& histogram;
  std::vector<Tick> ticks;                             ///< of the axis of values
  std::optional<std::pair<double, double>> good = {};  ///< a range of values to mark
};

/// A logarithmic histogram has counts on a logarithmic axis, a linear one shares.
class CountAxis {
 public:
  explicit CountAxis(const Histogram& histogram) : logarithmic_(histogram.logarithmic) {
    total_ = std::accumulate(histogram.counts.begin(), histogram.counts.end(),
                             static_cast<double>(histogram.below + histogram.above));
    const double highest = static_cast<double>(*std::ranges::max_element(histogram.counts));
    if (logarithmic_)
      top_ = std::max(1.0, std::ceil(std::log10(std::max(highest, 1.0)) + 0.05));
    else
      top_ = total_ > 0 && highest > 0 ? 1.08 * highest / total_ : 1;
  }
  /// From 0 at the foot to 1 at the top. On the logarithmic axis a single one is seen above the foot.
  double place(double count) const {
    if (!logarithmic_) return total_ > 0 ? count / total_ / top_ : 0;
    return count > 0 ? (std::log10(count) + kFoot) / (top_ + kFoot) : 0;
  }
  std::vector<std::pair<double, std::string>> ticks() const {
    std::vector<std::pair<double, std::string>> all;
    if (logarithmic_)
      for (const Tick& tick : decade_ticks(0, top_, 7)) all.emplace_back(place(tick.value), tick.label);
    else
      for (const Tick& tick : linear_ticks(0, 100 * top_, 5))
        all.emplace_back(tick.value / 100 / top_, tick.label + " %");
    return all;
  }

 private:
  static constexpr double kFoot = 0.3;  ///< decades below 1
  bool logarithmic_;
  double total_ = 0, top_ = 1;  ///< top: a share, or a power of ten
};

double place_on(const Histogram& histogram, double value) {
  return ((histogram.logarithmic ? std::log10(value) : value) - histogram.lo) / (histogram.hi - histogram.lo);
}

void draw_bars(Canvas& canvas, const Panel& panel, const CountAxis& axis) {
  const double width = panel.width / static_cast<double>(panel.histogram.counts.size());
  canvas.set_colour(viridis()[3]);
  for (std::size_t i = 0; i < panel.histogram.counts.size(); ++i) {
    const double height = panel.height * axis.place(static_cast<double>(panel.histogram.counts[i]));
    canvas.rectangle(panel.x + static_cast<double>(i) * width, panel.y + panel.height - height, 0.92 * width,
                     height);
  }
}

void draw_count_axis(Canvas& canvas, const Panel& panel, const CountAxis& axis, const Theme& theme) {
  for (const auto& [place, label] : axis.ticks()) {
    const double y = panel.y + panel.height * (1 - place);
    canvas.set_colour(theme.text, 0.12);
    canvas.line(panel.x, y, panel.x + panel.width, y, 1.5);
    canvas.set_colour(theme.text);
    canvas.text(label, panel.x - 0.4 * kFont, y, 0.85 * kFont, Align::right);
  }
}

void draw_value_axis(Canvas& canvas, const Panel& panel, const Theme& theme) {
  const double foot = panel.y + panel.height;
  canvas.set_colour(theme.text);
  canvas.line(panel.x, foot, panel.x + panel.width, foot, 2);
  for (const Tick& tick : panel.ticks) {
    const double x = panel.x + panel.width * place_on(panel.histogram, tick.value);
    canvas.line(x, foot, x, foot + 0.3 * kFont, 2);
    canvas.text(tick.label, x, foot + 0.95 * kFont, 0.85 * kFont, Align::centre);
  }
}

/// How many lie beyond the ends.
void draw_outside(Canvas& canvas, const Panel& panel, const Theme& theme) {
  canvas.set_colour(theme.text);
  const double y = panel.y + 0.6 * kFont;
  if (panel.histogram.below > 0)
    canvas.text(fmt::format("← {} below", panel.histogram.below), panel.x + 0.3 * kFont, y, 0.8 * kFont);
  if (panel.histogram.above > 0)
    canvas.text(fmt::format("{} above →", panel.histogram.above), panel.x + panel.width - 0.3 * kFont, y,
                0.8 * kFont, Align::right);
}

void draw_panel(Canvas& canvas, const Panel& panel, const Theme& theme) {
  const CountAxis axis(panel.histogram);
  if (panel.good) {
    const double from = place_on(panel.histogram, panel.good->first);
    const double to = place_on(panel.histogram, panel.good->second);
    canvas.set_colour(category_colour(3), 0.28);
    canvas.rectangle(panel.x + from * panel.width, panel.y, (to - from) * panel.width, panel.height);
  }
  draw_count_axis(canvas, panel, axis, theme);
  draw_bars(canvas, panel, axis);
  draw_value_axis(canvas, panel, theme);
  draw_outside(canvas, panel, theme);
  canvas.set_colour(theme.text);
  canvas.text(panel.title, panel.x + panel.width / 2, panel.y - 1.1 * kFont, kFont, Align::centre);
}

/// Drops empty bins at the ends, `step` at a time, but none of those between the values (exponents of values
/// on a logarithmic axis) `lo` and `hi`.
Histogram trimmed(Histogram histogram, std::ptrdiff_t step, double lo, double hi) {
  auto& counts = histogram.counts;
  const double width = (histogram.hi - histogram.lo) / static_cast<double>(counts.size());
  const double dropped = static_cast<double>(step) * width, rounding = width / 2;
  const auto is_empty = [&](auto first) {
    return std::all_of(first, first + step, [](auto n) { return n == 0; });
  };
  while (histogram.below == 0 && histogram.lo + dropped < lo + rounding && is_empty(counts.begin())) {
    counts.erase(counts.begin(), counts.begin() + step);
    histogram.lo += dropped;
  }
  while (histogram.above == 0 && histogram.hi - dropped > hi - rounding && is_empty(counts.end() - step)) {
    counts.erase(counts.end() - step, counts.end());
    histogram.hi -= dropped;
  }
  return histogram;
}

/// 0.01, 0.02, 0.05, 0.1 ... within the exponents lo and hi.
std::vector<Tick> ticks_1_2_5(double lo, double hi) {
  std::vector<Tick> ticks;
  for (int decade = static_cast<int>(std::floor(lo)); decade <= hi; ++decade)
    for (const double factor : {1, 2, 5}) {
      const double value = factor * std::pow(10, decade);
      if (std::log10(value) > lo - 1e-9 && std::log10(value) < hi + 1e-9)
        ticks.push_back({value, fmt::format("{:.3g}", value)});
    }
  return ticks;
}

}  // namespace

std::string histogram_plot(const Measures& m, const PlotText& text, Canvas::Format format) {
  const Theme& theme = light_theme();
  const std::unique_ptr<Canvas> sheet = make_canvas(format, kWidth, kHeight, theme.background);
  Canvas& canvas = *sheet;
  constexpr double kLeft = 130, kRight = 1050, kPlotWidth = 680, kPlotHeight = 385, kUpper = 195,
                   kLower = 810;
  const std::pair unit = {1 / std::numbers::sqrt2, std::numbers::sqrt2};
  const Histogram quality_log = trimmed(m.quality_log, 20, -1, 0);
  const Histogram length = trimmed(m.length, 10, 0, 2), length_log = trimmed(m.length_log, 1, -0.5, 0.5);
  const Panel panels[] = {{kLeft, kUpper, kPlotWidth, kPlotHeight, "quality, share of the tets", m.quality,
                           linear_ticks(0, 1, 5)},
                          {kRight, kUpper, kPlotWidth, kPlotHeight, "quality, number of tets", quality_log,
                           ticks_1_2_5(quality_log.lo, quality_log.hi)},
                          {kLeft, kLower, kPlotWidth, kPlotHeight, "length, share of the edges", length,
                           linear_ticks(0, length.hi, 8), unit},
                          {kRight, kLower, kPlotWidth, kPlotHeight, "length, number of edges", length_log,
                           ticks_1_2_5(length_log.lo, length_log.hi), unit}};
  for (const Panel& panel : panels) draw_panel(canvas, panel, theme);
  canvas.set_colour(theme.text);
  canvas.text(text.title, kWidth / 2.0, 45, 1.2 * kFont, Align::centre, true);
  canvas.text(text.tets, kWidth / 2.0, 105, 0.95 * kFont, Align::centre);
  canvas.text(text.edges, kWidth / 2.0, 715, 0.95 * kFont, Align::centre);
  return canvas.finish();
}

}  // namespace weft::picture
