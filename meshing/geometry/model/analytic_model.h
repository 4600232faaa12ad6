// Models of simple bodies without any CAD library: for tests, and to try what needs a model.
#pragma once

#include <memory>

#include "meshing/geometry/model/geometry_model.h"

namespace weft::meshing {

/// One face without border, as parametrised by SurfaceForm.
std::shared_ptr<const GeometryModel> ball_model(const Point& centre, double radius);

/// An upright solid: face 1 the side, with a seam; faces 2 and 3 the lower and the upper end. Edges 1 and 2
/// are the closed ones below and above, edge 3 the seam; node 1 is below, node 2 above. A cone's upper radius
/// may be zero: then edge 2 is degenerate, and there is no face 3.
std::shared_ptr<const GeometryModel> frustum_model(const Point& base, double lower_radius,
                                                   double upper_radius, double height);

/// The same side as `frustum_model` without formulas: what a spline is to the queries.
std::shared_ptr<const GeometryModel> without_formulas(std::shared_ptr<const GeometryModel> model);

}  // namespace weft::meshing
