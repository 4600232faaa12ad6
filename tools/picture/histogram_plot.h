// Histograms of a mesh's measures as a figure.
#pragma once

#include <string>

#include "meshing/measures.h"
#include "tools/picture/canvas.h"

namespace weft::picture {

/// The bytes of a file with four plots: quality of the tets and length of the edges, each with linear axes
/// (shares) and with logarithmic ones (counts, where single bad elements show). Values beyond an axis are
/// counted in words.
std::string histogram_plot(const meshing::Measures& measures, const std::string& title,
                           Canvas::Format format);

}  // namespace weft::picture
