// What is drawn: triangles with values, which a ColourScale turns into colours.
#pragma once

#include <array>
#include <cstdint>

#include "meshing/base/point.h"

namespace weft::picture {

/// How the three values of a facet spread over it.
enum class Blend : std::uint8_t {
  constant,      ///< the first value everywhere
  linear,        ///< one value a corner
  nearest_edge,  ///< value i, of the edge opposite corner i, on the third of the facet that lies at that edge
};

/// A flat triangle in space.
struct Facet {
  std::array<meshing::Point, 3> corners;
  std::array<double, 3> values = {};
  Blend blend = Blend::constant;
  std::array<bool, 3> edges = {true, true, true};  ///< whether the edge opposite corner i is drawn
  bool lit = true;                                 ///< whether its brightness depends on where it faces
  bool trimmed = false;                            ///< only what lies behind the scene's plane is drawn
};

/// Points on it fulfil dot(p, normal) = offset; what has more is *in front of* it, the rest behind.
struct Plane {
  meshing::Vec normal;
  double offset = 0;

  double distance(const meshing::Point& p) const { return dot(p, normal) - offset; }
};

}  // namespace weft::picture
