// Draws facets into pixels: a z-buffer with several samples a pixel, edges as thin lines.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/picture/camera.h"
#include "tools/picture/colour.h"
#include "tools/picture/facet.h"

namespace weft::picture {

/// Pixels row by row from the top, each 0x00RRGGBB.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint32_t> pixels;
};

struct RasterOptions {
  int width = 0, height = 0;  ///< in pixels
  ColourScale scale;
  Colour background, line;
  double line_width = 1;      ///< of edges, in pixels; 0: no edges
  std::optional<Plane> trim;  ///< what hides the trimmed facets' parts in front of it
  int samples = 3;            ///< a pixel, in each direction
};

/// The facets as `camera` sees them, both sides alike, lit from over the eye's left shoulder. Where edges lie
/// denser than pixels they fade, so that crowded places keep their colours. Multithreaded on TBB in the
/// caller's arena; the result does not depend on the number of threads. Temporaries: some 200 bytes a facet
/// that is in the picture, 16 bytes a sample for 16 rows of pixels per thread.
Image rasterize(std::span<const Facet> facets, const Camera& camera, const RasterOptions& options);

}  // namespace weft::picture
