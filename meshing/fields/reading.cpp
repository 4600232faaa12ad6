// Reads what is near, and again from farther off where that was not enough.
#include "meshing/fields/reading.h"

#include <algorithm>
#include <limits>
#include <span>

namespace weft::meshing {

Reading read(MeshPair& meshes, const ValueTable& at_old) {
  const MetricDomain& to = meshes.new_mesh();
  const std::span<const Point> points = to.mesh().points;
  for (;;) {
    Reading reading;
    const MeshData& source = meshes.source();
    reading.source = meshes.at_source(at_old);
    if (points.empty()) {
      reading.at.table.columns = at_old.columns;
    } else if (source.tets.empty()) {
      reading.at.distances.assign(points.size(), std::numeric_limits<double>::infinity());
      reading.at.outside.assign(points.size(), 1);
    } else {
      reading.locator.reset(new TetLocator(locator_in(source)));
      reading.at = interpolate(*reading.locator, reading.source, points);
    }
    if (meshes.widen(reading.at.distances)) continue;
    to.refresh(at_old.columns, reading.at.table.values);
    return reading;
  }
}

}  // namespace weft::meshing
