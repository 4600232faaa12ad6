// The limits that a metric field must keep, and its scaling to a complexity under them.
#pragma once

#include "meshing/metric/gradation.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

/// Makes every metric as fine as its aspect ratio demands (its largest size comes down), clamps sizes, limits
/// the gradation and clamps again, because an intersection can be finer than both that it intersects.
/// Once the domain is interrupted the gradation is left as it is. Throws InputError when hmin > hmax > 0.
void apply_limits(const MetricDomain& domain, const MetricLimits& limits, LogMetricField& field);

/// M <- limits(s M intersected with `demands`), with the one factor s for which the complexity is `target`
/// within 0.05 %, or the closest that 30 trials find where limits and demands forbid it. `demands`, where not
/// null, is a metric that is not to be scaled, such as that of first layers at walls. Returns the complexity
/// reached, the same on all parts of a mesh. Cost: that of apply_limits for every trial, three to eight of
/// them, one where the sizes' limits or the demands alone forbid the target; no more once the domain is
/// interrupted. Throws InputError for a mesh
/// without volume and a target that is not positive.
double fit_to_complexity(const MetricDomain& domain, double target, const MetricLimits& limits,
                         const LogMetricField* demands, LogMetricField& field);

// The same of a whole mesh.
void apply_limits(const MeshData& mesh, const MetricLimits& limits, LogMetricField& field);
double fit_to_complexity(const MeshData& mesh, double target, const MetricLimits& limits,
                         const LogMetricField* demands, LogMetricField& field);

}  // namespace weft::meshing
