// Points of the input with all that is known of them, on their way between ranks.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/metric/metric.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

struct PointRecord {
  meshing::Point point;
  meshing::LogMetric log_metric;
  std::int32_t ref;
  std::uint32_t number;  ///< in the whole input
};

/// The points of these numbers (ascending) from the ranks that have them; all ranks call together.
inline std::vector<PointRecord> fetch_points(Peers& peers, const MeshSlice& slice, const Ranges& points,
                                             const std::vector<std::uint32_t>& numbers) {
  return fetch<PointRecord>(peers, points, numbers, [&](std::size_t i) {
    return PointRecord{slice.points[i], slice.log_metrics[i], slice.point_refs[i],
                       static_cast<std::uint32_t>(slice.first_point + i)};
  });
}

}  // namespace weft::partition
