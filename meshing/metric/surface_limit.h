// Where a curved boundary bears no edges as long as the metric asks for.
#pragma once

#include <limits>
#include <optional>

#include "meshing/metric/metric_domain.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

struct LimitOfSurface {
  LogMetricField demand;  ///< what the metric is to be intersected with
  SurfaceLimit account;
};

/// `demand`: what the boundary needs at its vertices so that edges of length 1 stay near it
/// (curvature_metric() with half of hausd for its sagitta), largest_size elsewhere. Where edges of `field`
/// are longer than that by more than a quarter, the demand spreads from there into the volume, growing as a
/// gradation of 1.5 allows: short edges of the boundary beside long ones inside would be needles. If that
/// alone had more than the share `most` of the field's complexity, it is made coarser as a whole. Empty where
/// the field is fine enough.
std::optional<LimitOfSurface> limit_of_surface(const MetricDomain& domain, LogMetricField demand,
                                               const LogMetricField& field,
                                               double most = std::numeric_limits<double>::infinity());

}  // namespace weft::meshing
