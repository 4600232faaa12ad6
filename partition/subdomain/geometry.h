// The geometry of the whole boundary: the one thing of the input that every rank holds.
#pragma once

#include <vector>

#include "meshing/geometry/surface.h"

namespace weft::partition {

/// Immutable; shared by the subdomains of a rank. Patches and curves are global objects, and a surface is
/// small beside its volume.
struct Geometry {
  meshing::Surface surface;
  std::vector<bool> patch_required;  ///< patches made of required triangles
  std::vector<bool> patch_inner;     ///< patches with tets on both sides: material interfaces
};

}  // namespace weft::partition
