// Faces to facets to pixels; then the words around them.
#include "tools/picture/mesh_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "meshing/base/error.h"

namespace weft::picture {
namespace {

using meshing::Point;

/// The places of things on the sheet, in pixels.
struct Layout {
  double font, margin;
  double top;            ///< below the title
  double right;          ///< left of the legend
  double width, height;  ///< of the mesh's own part, from (0, top)
};

Layout lay_out(const Canvas& canvas, const PictureOptions& options, const Legend& legend) {
  Layout layout;
  layout.font = std::min(canvas.width(), canvas.height()) / 36.0;
  layout.margin = 0.8 * layout.font;
  layout.top = options.title.empty() ? 0 : 2.4 * layout.font;
  const double legend_column = options.legend ? legend_width(canvas, legend, layout.font) : 0;
  const double column = legend_column > 0 ? std::max(legend_column, 6 * layout.font) : 0;
  layout.right = column > 0 ? std::max(canvas.width() - column - 2 * layout.margin, canvas.width() / 4.0)
                            : canvas.width();
  layout.width = std::max(1.0, std::floor(layout.right));
  layout.height = std::max(1.0, std::floor(canvas.height() - layout.top));
  return layout;
}

std::vector<Facet> facets_of(const Surface& surface, const Colouring& colouring, const ColourSource& source,
                             const PictureOptions& options) {
  const bool whole_tets = options.cut && !options.planar;
  std::vector<Facet> facets;
  for (const ShownFace& face : whole_tets ? surface.behind(*options.cut) : surface.faces()) {
    facets.push_back(colouring.facet(face));
    facets.back().trimmed = options.cut && options.planar;
  }
  if (options.cut && options.planar)
    for (const Section& section : sections(source.mesh, *options.cut)) colouring.append(section, facets);
  return facets;
}

/// What the camera is to fit: the focus, or the whole surface, cut or not, so that pictures with different
/// cuts match.
std::vector<Point> fitted_points(const Surface& surface, const meshing::MeshData& mesh,
                                 const PictureOptions& options) {
  std::vector<Point> points;
  if (options.focus) {
    const auto& [lo, hi] = *options.focus;
    for (int i = 0; i < 8; ++i)
      points.push_back({i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z});
    return points;
  }
  std::vector<bool> used(mesh.points.size());
  for (const ShownFace& face : surface.faces())
    for (const std::uint32_t v : face.vertices) used[v] = true;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) points.push_back(mesh.points[v]);
  return points;
}

/// An arrow with its name, at (x0, y0).
void draw_axis(Canvas& canvas, const char* name, double x0, double y0, const Projected& tip, double font) {
  const double seen = std::hypot(tip.x, tip.y);
  const double x = tip.x / seen, y = tip.y / seen;
  const double head = std::min(0.55 * font, 0.6 * seen), tip_x = x0 + tip.x, tip_y = y0 + tip.y;
  const double foot_x = tip_x - head * x, foot_y = tip_y - head * y, half = 0.35 * head;
  canvas.line(x0, y0, foot_x, foot_y, 0.09 * font);
  canvas.triangle(tip_x, tip_y, foot_x - half * y, foot_y + half * x, foot_x + half * y, foot_y - half * x);
  canvas.text(name, tip_x + 0.6 * font * x, tip_y + 0.6 * font * y, 0.9 * font, Align::centre);
}

/// The directions of x, y and z: below the legend or, without one, in the lower left corner.
void draw_axes(Canvas& canvas, const Camera& camera, const Layout& layout, const Theme& theme) {
  const double length = 2.2 * layout.font, room = 3.4 * layout.font;
  const double x0 = layout.right < canvas.width() ? layout.right + room : room, y0 = canvas.height() - room;
  constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  canvas.set_colour(theme.text);
  for (int axis = 0; axis < 3; ++axis) {
    meshing::Vec direction;
    direction[axis] = length;
    const Projected tip = camera.turn(direction);
    const bool along_the_sight = std::hypot(tip.x, tip.y) < 0.1 * length;
    if (!along_the_sight) draw_axis(canvas, kNames[static_cast<std::size_t>(axis)], x0, y0, tip, layout.font);
  }
}

/// A sheet of paper gets two pixels of the image for each of its own.
int image_scale(Canvas::Format format) { return format == Canvas::Format::png ? 1 : 2; }

Image render(std::span<const Facet> facets, const Camera& camera, const Legend& legend, const Layout& layout,
             const PictureOptions& options, int scale) {
  const double unit = std::min(options.width, options.height) / 1200.0;
  RasterOptions raster;
  raster.width = scale * static_cast<int>(layout.width);
  raster.height = scale * static_cast<int>(layout.height);
  raster.scale = legend.scale;
  raster.background = options.theme.background;
  raster.line = options.theme.line;
  raster.line_width = options.line_width * scale * std::max(unit, 0.7);
  raster.trim = options.cut;
  return rasterize(facets, camera, raster);
}

}  // namespace

std::string mesh_picture(const ColourSource& source, const meshing::RefNames& names,
                         const PictureOptions& options, Canvas::Format format) {
  const Surface surface(source.mesh, options.only);
  if (surface.faces().empty())
    throw meshing::InputError("", "",
                              options.only ? "has no triangles of these references" : "has nothing to show");
  const Colouring colouring(source);
  const std::vector<Facet> facets = facets_of(surface, colouring, source, options);
  if (facets.empty()) throw meshing::InputError("", "", "has nothing behind the plane of the cut");
  const Legend legend = colouring.legend(facets, names, options.theme, options.range);

  const std::unique_ptr<Canvas> sheet =
      make_canvas(format, options.width, options.height, options.theme.background);
  Canvas& canvas = *sheet;
  const Layout layout = lay_out(canvas, options, legend);
  const int scale = image_scale(format);
  const Camera camera(options.view, fitted_points(surface, source.mesh, options), scale * layout.width,
                      scale * layout.height, options.zoom);
  canvas.image(render(facets, camera, legend, layout, options, scale), 0, layout.top, layout.width,
               layout.height);
  canvas.set_colour(options.theme.text);
  canvas.text(options.title, canvas.width() / 2.0, 1.3 * layout.font, 1.2 * layout.font, Align::centre, true);
  if (options.axes) draw_axes(canvas, camera, layout, options.theme);
  if (options.legend)
    draw_legend(canvas, legend, layout.font, layout.right + layout.margin, layout.top + 2 * layout.font,
                layout.height - 9.5 * layout.font, options.theme);
  return canvas.finish();
}

}  // namespace weft::picture
