// What all subdomains know of the geometry of the whole boundary.
#pragma once

#include <vector>

#include "meshing/geometry/surface/surface.h"

namespace weft::partition {

/// Immutable; shared by the subdomains of a rank. Patches and curves are global objects, and few; what lies
/// between is in pieces, which each subdomain has of its own boundary (Subdomain::surface).
struct Geometry {
  meshing::Surface surface;            ///< without pieces
  std::vector<bool> patch_required;    ///< patches made of required triangles
  std::vector<bool> patch_inner;       ///< patches with tets on both sides: material interfaces
  meshing::ModelFaults on_model = {};  ///< of the input
};

}  // namespace weft::partition
