// Every rank's share of the input mesh with its metric.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/geometry/model.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/peers.h"
#include "partition/distribute/mesh_slice.h"
#include "weft/weft.h"

namespace weft::tools {

struct SliceInput {
  partition::MeshSlice slice;
  double target_complexity = 0;  ///< that the slice's metric still has to be scaled to; 0: as it is
  std::vector<std::string> warnings;
  /// The whole input with its metric, where one rank has read it whole; only on rank 0.
  std::optional<meshing::MeshData> whole;
  meshing::LogMetricField whole_metric;
  meshing::RefNames names;  ///< of the input's references; on rank 0 at least
  std::vector<Mend> mends;  ///< of the input, on rank 0
  Fields fields;            ///< those that are carried along, at the slice's points
};

/// All ranks: reads the mesh and makes the metric. A mesh of which ranges can be read
/// (meshing::size_for_ranges) with metric and fields in GMF files are read in shares, no rank holds more.
/// Anything else (other formats, repair) needs the whole mesh: rank 0 reads and prepares it, and hands out
/// the shares. Throws meshing::InputError alike on all ranks.
SliceInput read_slice(partition::Peers& peers, const Files& files, const Options& options,
                      const std::shared_ptr<const meshing::Model>& model);

/// All ranks: the shares of a mesh that rank 0 has whole (elsewhere `mesh` is empty), with its metric.
partition::MeshSlice deal_out(partition::Peers& peers, const meshing::MeshData& mesh,
                              const meshing::LogMetricField& metric);

/// All ranks: the whole mesh of the slices on rank 0; elsewhere empty.
meshing::MeshData gather_whole(partition::Peers& peers, const partition::MeshSlice& slice);
/// All ranks: the values of all ranks on rank 0, in their order; elsewhere none.
std::vector<meshing::LogMetric> gather_to_first(partition::Peers& peers,
                                                const std::vector<meshing::LogMetric>& mine);
std::vector<double> gather_to_first(partition::Peers& peers, const std::vector<double>& mine);
Fields gather_to_first(partition::Peers& peers, const Fields& mine);
/// All ranks: of values at the whole mesh's points, which rank 0 has, those at the slice's points.
std::vector<meshing::LogMetric> deal_by_slices(partition::Peers& peers,
                                               const std::vector<meshing::LogMetric>& whole,
                                               const partition::MeshSlice& slice);

}  // namespace weft::tools
