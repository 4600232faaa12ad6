// Histograms of a mesh's measures as a figure.
#pragma once

#include <string>

#include "meshing/metric/measures.h"
#include "tools/picture/canvas.h"

namespace weft::picture {

/// What stands over the plots.
struct PlotText {
  std::string title;
  std::string tets, edges;  ///< over the plots of quality and of length
};

/// The bytes of a file with four plots: quality of the tets and length of the edges, each with linear axes
/// (shares) and with logarithmic ones (counts, where single bad elements show). Axes end where there are
/// no more values; those beyond the ends of the measures' histograms are counted in words.
std::string histogram_plot(const meshing::Measures& measures, const PlotText& text, Canvas::Format format);

}  // namespace weft::picture
