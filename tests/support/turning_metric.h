// A mesh far too coarse for its metric, which turns within the thickness of the domain.
#pragma once

#include <random>

#include "meshing/mesh/structured_box.h"
#include "meshing/metric/metric_field.h"

namespace weft::support {

/// Twelve tets, one fiftieth as thick as wide.
inline meshing::MeshData thin_slab() {
  meshing::BoxOptions options;
  options.cells = {1, 1, 2};
  options.max = {1, 1, 0.02};
  return meshing::structured_box(options);
}

/// A tensor at each vertex, drawn anew: sizes of a ratio of up to about 30 along any directions.
inline meshing::LogMetricField turning_metric(const meshing::MeshData& mesh, double complexity,
                                              unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  meshing::LogMetricField field;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    field.push_back(
        {3 * u(random), 2 * u(random), 3 * u(random), 2 * u(random), 2 * u(random), 3 * u(random)});
  meshing::scale_to_complexity(mesh, complexity, field);
  return field;
}

}  // namespace weft::support
