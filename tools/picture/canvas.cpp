#include "tools/picture/canvas.h"

#include <filesystem>
#include <stdexcept>

#include "meshing/base/load_part.h"

namespace weft::picture {

std::unique_ptr<Canvas> make_canvas(Canvas::Format format, int width, int height, const Colour& background) {
  constexpr const char* kFile = "libweft_cairo.so";
  static const meshing::Part part = meshing::load_part(kFile, kCanvasEntryName, kCanvasInterface);
  if (!part.offer)
    throw std::runtime_error("drawing failed: " +
                             meshing::missing_part_text(part, kFile, "cairo", "libcairo2"));
  return static_cast<const CanvasMaker*>(part.offer)->make(format, width, height, background);
}

std::optional<Canvas::Format> Canvas::format_of(const std::string& name) {
  const std::string extension = std::filesystem::path(name).extension().string();
  if (extension == ".png") return Format::png;
  if (extension == ".svg") return Format::svg;
  if (extension == ".pdf") return Format::pdf;
  return std::nullopt;
}

}  // namespace weft::picture
