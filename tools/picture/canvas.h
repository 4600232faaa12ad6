// A sheet to draw on, and the only door to the drawing library.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tools/picture/colour.h"
#include "tools/picture/raster.h"

namespace weft::picture {

/// Where a text stands relative to the place that is given for it.
enum class Align { left, centre, right };

/// Coordinates are pixels from the upper left corner. On paper (PDF, SVG) 200 of them are an inch. Failures
/// of the library (such as no memory) throw std::runtime_error.
class Canvas {
 public:
  enum class Format { png, svg, pdf };
  Canvas(Format format, int width, int height, const Colour& background);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }

  /// Of all that is drawn next.
  void set_colour(const Colour& colour, double opacity = 1);
  void rectangle(double x, double y, double width, double height);
  void line(double x0, double y0, double x1, double y1, double line_width);
  /// A filled arrow head's triangle, or any other.
  void triangle(double x0, double y0, double x1, double y1, double x2, double y2);
  /// `y` is the middle of the capital letters' height.
  void text(const std::string& text, double x, double y, double size, Align align = Align::left,
            bool bold = false);
  double text_width(const std::string& text, double size, bool bold = false) const;
  /// The image's pixels on a rectangle of the canvas.
  void image(const Image& image, double x, double y, double width, double height);

  /// The bytes of the file. Nothing may be drawn afterwards.
  std::string finish();

  /// The format that the name's extension asks for; nothing for other extensions.
  static std::optional<Format> format_of(const std::string& name);

 private:
  struct Handles;

  int width_, height_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace weft::picture
