// On cairo.
#include "tools/picture/canvas.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <stdexcept>

#include "meshing/base/printable.h"

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

}  // namespace

struct Canvas::Handles {
  Format format;
  std::string bytes;  // the surface writes into it until it is gone: declared before it
  SurfacePtr surface;
  ContextPtr context;

  cairo_t* font(double size, bool bold) const {
    cairo_select_font_face(context.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context.get(), size);
    return context.get();
  }
};

Canvas::Canvas(Format format, int width, int height, const Colour& background)
    : width_(width), height_(height), handles_(new Handles{format, {}, {}, {}}) {
  handles_->surface = make_surface(format, width, height, &handles_->bytes);
  handles_->context.reset(cairo_create(handles_->surface.get()));
  check(cairo_status(handles_->context.get()));
  if (format != Format::png) cairo_scale(handles_->context.get(), kPointsPerPixel, kPointsPerPixel);
  set_colour(background);
  rectangle(0, 0, width, height);
}

Canvas::~Canvas() = default;

void Canvas::set_colour(const Colour& colour, double opacity) {
  cairo_set_source_rgba(handles_->context.get(), colour.red, colour.green, colour.blue, opacity);
}

void Canvas::rectangle(double x, double y, double width, double height) {
  cairo_rectangle(handles_->context.get(), x, y, width, height);
  cairo_fill(handles_->context.get());
}

void Canvas::line(double x0, double y0, double x1, double y1, double line_width) {
  cairo_t* context = handles_->context.get();
  cairo_set_line_width(context, line_width);
  cairo_move_to(context, x0, y0);
  cairo_line_to(context, x1, y1);
  cairo_stroke(context);
}

void Canvas::triangle(double x0, double y0, double x1, double y1, double x2, double y2) {
  cairo_t* context = handles_->context.get();
  cairo_move_to(context, x0, y0);
  cairo_line_to(context, x1, y1);
  cairo_line_to(context, x2, y2);
  cairo_close_path(context);
  cairo_fill(context);
}

double Canvas::text_width(const std::string& text, double size, bool bold) const {
  cairo_text_extents_t extents;
  cairo_text_extents(handles_->font(size, bold), meshing::printable(text).c_str(), &extents);
  return extents.x_advance;
}

void Canvas::text(const std::string& text, double x, double y, double size, Align align, bool bold) {
  constexpr double kHalfCapital = 0.36;  // of the font size
  const double share = align == Align::left ? 0 : align == Align::centre ? 0.5 : 1;
  const double left = x - (share > 0 ? share * text_width(text, size, bold) : 0);
  cairo_t* context = handles_->font(size, bold);
  cairo_move_to(context, left, y + kHalfCapital * size);
  cairo_show_text(context, meshing::printable(text).c_str());  // one byte that is no UTF-8 fails all
}

void Canvas::image(const Image& image, double x, double y, double width, double height) {
  SurfacePtr pixels(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  check(cairo_surface_status(pixels.get()));
  unsigned char* rows = cairo_image_surface_get_data(pixels.get());
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(pixels.get()));
  const auto columns = static_cast<std::size_t>(image.width);
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row)
    std::copy_n(image.pixels.data() + row * columns, columns,
                reinterpret_cast<std::uint32_t*>(rows + row * stride));
  cairo_surface_mark_dirty(pixels.get());
  cairo_t* context = handles_->context.get();
  cairo_save(context);
  cairo_translate(context, x, y);
  cairo_scale(context, width / image.width, height / image.height);
  cairo_set_source_surface(context, pixels.get(), 0, 0);
  cairo_paint(context);
  cairo_restore(context);
}

std::string Canvas::finish() {
  check(cairo_status(handles_->context.get()));
  if (handles_->format == Format::png)
    check(cairo_surface_write_to_png_stream(handles_->surface.get(), append, &handles_->bytes));
  cairo_surface_finish(handles_->surface.get());
  check(cairo_surface_status(handles_->surface.get()));
  return std::move(handles_->bytes);
}

std::optional<Canvas::Format> Canvas::format_of(const std::string& name) {
  const std::string extension = std::filesystem::path(name).extension().string();
  if (extension == ".png") return Format::png;
  if (extension == ".svg") return Format::svg;
  if (extension == ".pdf") return Format::pdf;
  return std::nullopt;
}

}  // namespace weft::picture
