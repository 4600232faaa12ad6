// A sheet to draw on. What draws is a part of weft that is loaded for the first one.
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
  virtual ~Canvas() = default;
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }

  /// Of all that is drawn next.
  virtual void set_colour(const Colour& colour, double opacity = 1) = 0;
  virtual void rectangle(double x, double y, double width, double height) = 0;
  virtual void line(double x0, double y0, double x1, double y1, double line_width) = 0;
  /// A filled arrow head's triangle, or any other.
  virtual void triangle(double x0, double y0, double x1, double y1, double x2, double y2) = 0;
  /// `y` is the middle of the capital letters' height.
  virtual void text(const std::string& text, double x, double y, double size, Align align = Align::left,
                    bool bold = false) = 0;
  virtual double text_width(const std::string& text, double size, bool bold = false) const = 0;
  /// The image's pixels on a rectangle of the canvas.
  virtual void image(const Image& image, double x, double y, double width, double height) = 0;

  /// The bytes of the file. Nothing may be drawn afterwards.
  virtual std::string finish() = 0;

  /// The format that the name's extension asks for; nothing for other extensions.
  static std::optional<Format> format_of(const std::string& name);

 protected:
  Canvas(int width, int height) : width_(width), height_(height) {}

 private:
  int width_, height_;
};

/// Throws std::runtime_error also where the part that draws cannot be loaded.
std::unique_ptr<Canvas> make_canvas(Canvas::Format format, int width, int height, const Colour& background);

/// What that part offers (see load_part.h).
struct CanvasMaker {
  decltype(&make_canvas) make;
};
inline constexpr const char* kCanvasEntryName = "weft_canvas_maker";
inline constexpr int kCanvasInterface = 1;

}  // namespace weft::picture
