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
  canvas.text(panel.title, panel.x + panel.width / 2, panel.y - 0.8 * kFont, kFont, Align::centre);
}

std::string quality_line(const Measures& m) {
  return fmt::format("{} tets: mean ratio {:.3f} in the mean, worst 1 % below {:.3f}, least {:.3g}",
                     m.num_tets, m.quality_mean, m.quality_q01, m.quality_min);
}

std::string length_line(const Measures& m) {
  return fmt::format(
      "{} edges: {:.1f} % unit (shaded), {:.2f} % shorter, {:.2f} % longer, from {:.3g} to {:.3g}",
      m.num_edges, 100 * m.edges_unit, 100 * m.edges_short, 100 * m.edges_long, m.length_min, m.length_max);
}

}  // namespace

std::string histogram_plot(const Measures& m, const std::string& title, Canvas::Format format) {
  const Theme& theme = light_theme();
  Canvas canvas(format, kWidth, kHeight, theme.background);
  constexpr double kLeft = 130, kMiddle = 1050, kPlotWidth = 680, kPlotHeight = 375, kUpper = 195,
                   kLower = 800;
  const std::pair unit = {1 / std::numbers::sqrt2, std::numbers::sqrt2};
  const std::vector<Tick> log_lengths = {{0.05, "0.05"}, {0.1, "0.1"}, {0.2, "0.2"}, {0.5, "0.5"}, {1, "1"},
                                         {2, "2"},       {5, "5"},     {10, "10"},   {20, "20"}};
  const Panel panels[] = {
      {kLeft, kUpper, kPlotWidth, kPlotHeight, "quality, share of the tets", m.quality,
       linear_ticks(0, 1, 5)},
      {kMiddle, kUpper, kPlotWidth, kPlotHeight, "quality, number of tets", m.quality_log,
       decade_ticks(-4, 0, 5)},
      {kLeft, kLower, kPlotWidth, kPlotHeight, "length, share of the edges", m.length, linear_ticks(0, 4, 8),
       unit},
      {kMiddle, kLower, kPlotWidth, kPlotHeight, "length, number of edges", m.length_log, log_lengths, unit}};
  for (const Panel& panel : panels) draw_panel(canvas, panel, theme);
  canvas.set_colour(theme.text);
  canvas.text(title, kWidth / 2.0, 45, 1.2 * kFont, Align::centre, true);
  canvas.text(quality_line(m), kWidth / 2.0, 105, 0.95 * kFont, Align::centre);
  canvas.text(length_line(m), kWidth / 2.0, 700, 0.95 * kFont, Align::centre);
  return canvas.finish();
}

}  // namespace weft::picture
