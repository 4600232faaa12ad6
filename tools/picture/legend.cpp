// Bar or patches, with their labels to the right.
#include "tools/picture/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/picture/canvas.h"

namespace weft::picture {
namespace {

// All in units of the font size.
constexpr double kPatch = 0.9, kLine = 1.45, kGap = 0.5, kTitleHeight = 1.7;
constexpr int kBarSteps = 256;

void draw_bar(Canvas& canvas, const Legend& legend, double font_size, double x, double y, double height,
              const Theme& theme) {
  const ColourScale& scale = legend.scale;
  const double width = std::round(kPatch * font_size), step = height / kBarSteps;
  const bool logarithmic = scale.kind == ColourScale::Kind::logarithmic;
  for (int i = 0; i < kBarSteps; ++i) {
    const double share = 1 - (i + 0.5) / kBarSteps;
    const double value = logarithmic ? scale.lo * std::pow(scale.hi / scale.lo, share)
                                     : scale.lo + share * (scale.hi - scale.lo);
    canvas.set_colour(scale.colour(value));
    // All the way down, to be covered by the next steps: no seams show.
    canvas.rectangle(x, y + i * step, width, height - i * step);
  }
  canvas.set_colour(theme.text);
  for (const Tick& tick : legend.ticks) {
    const double share = scale.hi > scale.lo ? scale.place(tick.value) : 0.5;
    if (!(share > -1e-9 && share < 1 + 1e-9)) continue;
    const double at = y + height * (1 - share);
    canvas.line(x + width, at, x + width + 0.25 * font_size, at, 0.06 * font_size);
    canvas.text(tick.label, x + width + kGap * font_size, at, font_size);
  }
}

void draw_entries(Canvas& canvas, const Legend& legend, double font_size, double x, double y, double height,
                  const Theme& theme) {
  const auto room = static_cast<std::size_t>(std::max(1.0, std::floor(height / (kLine * font_size))));
  const std::size_t n = legend.entries.size();
  const std::size_t shown = n <= room ? n : room - 1;
  for (std::size_t i = 0; i < shown; ++i, y += kLine * font_size) {
    const auto& [category, label] = legend.entries[i];
    canvas.set_colour(legend.scale.colour(static_cast<double>(category)));
    canvas.rectangle(x, y - kPatch * font_size / 2, kPatch * font_size, kPatch * font_size);
    canvas.set_colour(theme.text);
    canvas.text(label, x + (kPatch + kGap) * font_size, y, font_size);
  }
  if (shown < n) canvas.text(fmt::format("and {} more", n - shown), x, y, font_size);
}

}  // namespace

double legend_width(const Canvas& canvas, const Legend& legend, double font_size) {
  if (legend.empty()) return 0;
  double widest = 0;
  for (const Tick& tick : legend.ticks) widest = std::max(widest, canvas.text_width(tick.label, font_size));
  for (const auto& entry : legend.entries)
    widest = std::max(widest, canvas.text_width(entry.label, font_size));
  return std::max((kPatch + kGap) * font_size + widest, canvas.text_width(legend.title, font_size));
}

void draw_legend(Canvas& canvas, const Legend& legend, double font_size, double x, double y, double height,
                 const Theme& theme) {
  if (legend.empty()) return;
  canvas.set_colour(theme.text);
  canvas.text(legend.title, x, y + 0.5 * font_size, font_size);
  const double below = y + kTitleHeight * font_size, left = height - kTitleHeight * font_size;
  if (legend.ticks.empty())
    draw_entries(canvas, legend, font_size, x, below + kPatch * font_size / 2, left, theme);
  else
    draw_bar(canvas, legend, font_size, std::round(x), std::round(below), std::round(left), theme);
}

}  // namespace weft::picture
