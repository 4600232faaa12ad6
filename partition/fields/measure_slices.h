// Measures of a mesh in slices, without gathering it.
#pragma once

#include <cstdint>
#include <map>

#include "meshing/base/box.h"
#include "meshing/metric/measures.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// All ranks: what meshing::measure says of the whole mesh in the metric of the slices: counts and qualities
/// exactly, sums and lengths but for rounding. The same on all ranks. The metric is scaled to
/// `target_complexity` first; 0: as it is.
meshing::Measures measure_slices(Peers& peers, const MeshSlice& slice, double target_complexity = 0);

/// All ranks: the complexity of the whole mesh in the metric of the slices, but for rounding; the same on all
/// ranks.
double complexity_of_slices(Peers& peers, const MeshSlice& slice);

/// What can be said without a metric.
struct SlicesGeometry {
  meshing::Box box;
  meshing::ShapeMeasures shape;
  std::map<std::int32_t, double> volume_by_ref, area_by_ref;
};
/// All ranks: of the whole mesh, sums but for rounding; the same on all ranks.
SlicesGeometry measure_geometry_of_slices(Peers& peers, const MeshSlice& slice);

}  // namespace weft::partition
