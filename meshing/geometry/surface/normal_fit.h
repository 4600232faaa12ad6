// A vertex normal from a local fit of the surface.
#pragma once

#include <span>

#include "meshing/base/point.h"

namespace weft::meshing {

/// A fit or tangent that turns the mean normal by more (26 degrees) contradicts the triangles and is not
/// used.
inline constexpr double kTrustedCosine = 0.9;

/// Unit normal at the origin of the surface through the points of `ring`, which has the known unit `tangents`
/// there. The fit's normal counts as far as its correction to `mean` stands out from its own uncertainty,
/// which is none on a sphere or a cylinder; where the points determine none, `mean` comes back.
Vec improved_normal(std::span<const Vec> ring, std::span<const Vec> tangents, const Vec& mean);

}  // namespace weft::meshing
