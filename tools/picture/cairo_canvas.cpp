// The part of weft that knows cairo.
#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include "meshing/base/printable.h"
#include "tools/picture/canvas.h"

namespace weft::picture {
namespace {

constexpr double kPointsPerPixel = 72.0 / 200;

void check(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("drawing failed: ") + cairo_status_to_string(status));
}

struct FreeSurface {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
struct FreeContext {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using SurfacePtr = std::unique_ptr<cairo_surface_t, FreeSurface>;
using ContextPtr = std::unique_ptr<cairo_t, FreeContext>;

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int size) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), size);
  return CAIRO_STATUS_SUCCESS;
}

SurfacePtr make_surface(Canvas::Format format, int width, int height, std::string* bytes) {
  const double page_width = width * kPointsPerPixel, page_height = height * kPointsPerPixel;
  SurfacePtr surface(format == Canvas::Format::pdf
                         ? cairo_pdf_surface_create_for_stream(append, bytes, page_width, page_height)
                     : format == Canvas::Format::svg
                         ? cairo_svg_surface_create_for_stream(append, bytes, page_width, page_height)
                         : cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
  check(cairo_surface_status(surface.get()));
  return surface;
}

class CairoCanvas final : public Canvas {
 public:
  CairoCanvas(Format format, int width, int height)
      : Canvas(width, height), format_(format), surface_(make_surface(format, width, height, &bytes_)) {
    context_.reset(cairo_create(surface_.get()));
    check(cairo_status(context_.get()));
    if (format != Format::png) cairo_scale(context_.get(), kPointsPerPixel, kPointsPerPixel);
  }

  void set_colour(const Colour& colour, double opacity) override;
  void rectangle(double x, double y, double width, double height) override;
  void line(double x0, double y0, double x1, double y1, double line_width) override;
  void triangle(double x0, double y0, double x1, double y1, double x2, double y2) override;
  void text(const std::string& text, double x, double y, double size, Align align, bool bold) override;
  double text_width(const std::string& text, double size, bool bold) const override;
  void image(const Image& image, double x, double y, double width, double height) override;
  std::string finish() override;

 private:
  cairo_t* font(double size, bool bold) const {
    cairo_select_font_face(context_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context_.get(), size);
    return context_.get();
  }

  Format format_;
  std::string bytes_;  // the surface writes into it until it is gone: declared before it
  SurfacePtr surface_;
  ContextPtr context_;
};

void CairoCanvas::set_colour(const Colour& colour, double opacity) {
  cairo_set_source_rgba(context_.get(), colour.red, colour.green, colour.blue, opacity);
}

void CairoCanvas::rectangle(double x, double y, double width, double height) {
  cairo_rectangle(context_.get(), x, y, width, height);
  cairo_fill(context_.get());
}

void CairoCanvas::line(double x0, double y0, double x1, double y1, double line_width) {
  cairo_t* context = context_.get();
  cairo_set_line_width(context, line_width);
  cairo_move_to(context, x0, y0);
  cairo_line_to(context, x1, y1);
  cairo_stroke(context);
}

void CairoCanvas::triangle(double x0, double y0, double x1, double y1, double x2, double y2) {
  cairo_t* context = context_.get();
  cairo_move_to(context, x0, y0);
  cairo_line_to(context, x1, y1);
  cairo_line_to(context, x2, y2);
  cairo_close_path(context);
  cairo_fill(context);
}

double CairoCanvas::text_width(const std::string& text, double size, bool bold) const {
  cairo_text_extents_t extents;
  cairo_text_extents(font(size, bold), meshing::printable(text).c_str(), &extents);
  return extents.x_advance;
}

void CairoCanvas::text(const std::string& text, double x, double y, double size, Align align, bool bold) {
  constexpr double kHalfCapital = 0.36;  // of the font size
  const double share = align == Align::left ? 0 : align == Align::centre ? 0.5 : 1;
  const double left = x - (share > 0 ? share * text_width(text, size, bold) : 0);
  cairo_t* context = font(size, bold);
  cairo_move_to(context, left, y + kHalfCapital * size);
  cairo_show_text(context, meshing::printable(text).c_str());  // one byte that is no UTF-8 fails all
}

void CairoCanvas::image(const Image& image, double x, double y, double width, double height) {
  SurfacePtr pixels(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  check(cairo_surface_status(pixels.get()));
  unsigned char* rows = cairo_image_surface_get_data(pixels.get());
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(pixels.get()));
  const auto columns = static_cast<std::size_t>(image.width);
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row)
    std::copy_n(image.pixels.data() + row * columns, columns,
                reinterpret_cast<std::uint32_t*>(rows + row * stride));
  cairo_surface_mark_dirty(pixels.get());
  cairo_t* context = context_.get();
  cairo_save(context);
  cairo_translate(context, x, y);
  cairo_scale(context, width / image.width, height / image.height);
  cairo_set_source_surface(context, pixels.get(), 0, 0);
  cairo_paint(context);
  cairo_restore(context);
}

std::string CairoCanvas::finish() {
  check(cairo_status(context_.get()));
  if (format_ == Format::png) check(cairo_surface_write_to_png_stream(surface_.get(), append, &bytes_));
  cairo_surface_finish(surface_.get());
  check(cairo_surface_status(surface_.get()));
  return std::move(bytes_);
}

std::unique_ptr<Canvas> make_cairo_canvas(Canvas::Format format, int width, int height,
                                          const Colour& background) {
  auto canvas = std::make_unique<CairoCanvas>(format, width, height);
  canvas->set_colour(background, 1);
  canvas->rectangle(0, 0, width, height);
  return canvas;
}

}  // namespace
}  // namespace weft::picture

extern "C" __attribute__((visibility("default"))) const void* weft_canvas_maker(int interface) {
  using namespace weft::picture;
  static constexpr CanvasMaker maker = {make_cairo_canvas};
  return interface == kCanvasInterface ? &maker : nullptr;
}
