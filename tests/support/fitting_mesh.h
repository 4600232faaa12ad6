// A mesh that weft has adapted, of a few blocks of meshing/metric/fit.h.
#pragma once

#include <cmath>

#include "meshing/adapt/adapt.h"
#include "meshing/metric/metric.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::support {

/// The metric whose edges are `factor` times shorter: lengths in it are `factor` times longer.
inline meshing::LogMetric times(double factor, const meshing::LogMetric& log_metric) {
  return log_metric + 2 * std::log(factor) * meshing::LogMetric(meshing::identity_tensor(1));
}

/// A box of two materials, twice as high as wide, with edges of about `size`.
inline MetricMesh fitting_mesh(double size) {
  const MeshData box = layered_box(4, 4, 2);
  const meshing::LogMetricField wanted(box.points.size(), times(1 / size, {}));
  meshing::AdaptResult adapted = meshing::adapt(box, {&box, &wanted}, {});
  return {std::move(adapted.mesh), std::move(adapted.log_metrics)};
}

/// Made once: 30,000 tets.
inline const MetricMesh& fitting_mesh() {
  static const MetricMesh mesh = fitting_mesh(0.085);
  return mesh;
}

}  // namespace weft::support
