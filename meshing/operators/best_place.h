// Where the centre of a ball makes its tets best.
#pragma once

#include <optional>

#include "meshing/base/point.h"
#include "meshing/kernel/ball_objective.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// best_place() takes no more faces than these.
inline constexpr int kMostFaces = 64;

/// Minimises the sum of 1/Q^4 over the gathered faces (nearly the worst tet alone) by Levenberg-Marquardt,
/// Ceres' TinySolver, from `from` on, where the centre has `metric`, and what the judges add up is `tensor`.
/// Empty where it stays there.
std::optional<Point> best_place(BallFaces& faces, const Point& from, const Metric& metric,
                                const SymTensor& tensor);

}  // namespace weft::meshing
