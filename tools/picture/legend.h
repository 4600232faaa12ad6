// The legend of a picture: a bar for a continuous scale, patches of colour for things with names.
#pragma once

#include <string>
#include <vector>

#include "tools/picture/axis_scale.h"
#include "tools/picture/colour.h"

namespace weft::picture {

class Canvas;

struct Legend {
  std::string title;
  ColourScale scale;
  std::vector<Tick> ticks;  ///< of a continuous scale
  /// Of a discrete scale: the colour's place on it, and what has that colour.
  struct Entry {
    std::size_t category;
    std::string label;
  };
  std::vector<Entry> entries;

  bool empty() const { return ticks.empty() && entries.empty(); }
};

/// How wide `legend` will be, in the canvas's units.
double legend_width(const Canvas& canvas, const Legend& legend, double font_size);
/// Draws it from (x, y) down, at most `height` high; entries that have no room are counted in the last line.
void draw_legend(Canvas& canvas, const Legend& legend, double font_size, double x, double y, double height,
                 const Theme& theme);

}  // namespace weft::picture
