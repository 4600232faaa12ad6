// What coordinates the readers of meshes let pass.
#pragma once

#include <cmath>

namespace weft::meshing {

/// `any` is for repair_mesh(), which judges them.
enum class Coordinates { finite, any };

inline bool passes(double coordinate, Coordinates wanted) {
  return wanted == Coordinates::any || std::isfinite(coordinate);
}

}  // namespace weft::meshing
