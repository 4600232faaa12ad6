// A picture of a mesh: what is shown, from where, with title, legend and axes.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "tools/picture/camera.h"
#include "tools/picture/canvas.h"
#include "tools/picture/colouring.h"

namespace weft::picture {

struct PictureOptions {
  int width = 1600, height = 1200;
  Theme theme = light_theme();
  std::string title;
  bool legend = true, axes = true;
  double line_width = 1;  ///< of the mesh's edges, in 1200ths of the picture's smaller side; 0: no edges

  View view{{1, -1, 1}, {0, 0, 1}};
  double zoom = 1;
  std::optional<meshing::Box> focus;  ///< what is to fill the picture; default: the surface

  std::optional<Plane> cut;  ///< takes away what lies in front of it
  bool planar = false;       ///< the cut is a plane section, not one along the faces of whole tets
  std::optional<std::vector<std::int32_t>> only;   ///< references of the triangles that are shown
  std::optional<std::pair<double, double>> range;  ///< of a continuous colour scale
};

/// The bytes of a file with the picture. Throws InputError (no file name) for a mesh that cannot be shown:
/// indices out of range, faces of more than two tets, nothing to see.
std::string mesh_picture(const ColourSource& source, const meshing::RefNames& names,
                         const PictureOptions& options, Canvas::Format format);

}  // namespace weft::picture
