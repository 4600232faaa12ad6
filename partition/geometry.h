// The geometry that all subdomains of a rank share.
#pragma once

#include <vector>

#include "meshing/surface.h"

namespace weft::partition {

/// The whole mesh's boundary as reference geometry; immutable, one a rank.
struct Geometry {
  meshing::Surface surface;
  std::vector<bool> patch_required;  ///< patches made of required triangles
};

}  // namespace weft::partition
