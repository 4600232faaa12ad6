// Every rank's share of the input mesh with its metric.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/geometry/model/model.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "weft/weft.h"

namespace weft::tools {

struct SliceInput {
  partition::MeshSlice slice;
  /// Another mesh that the metric belongs to, with it; the slice has none then. No boundary.
  std::optional<partition::MeshSlice> background;
  double target_complexity = 0;  ///< that the slice's metric still has to be scaled to; 0: as it is
  std::vector<std::string> warnings;
  meshing::SurfaceLimit surface_limit = {};
  meshing::RefNames names;    ///< of the input's references; on rank 0 at least
  std::vector<Mend> mends;    ///< of the input, on rank 0
  Fields fields;              ///< those that are carried along, at the slice's points
  double metric_seconds = 0;  ///< that the metric took, from its files on
};

/// All ranks: reads the mesh and makes the metric, in shares where the formats allow (read_mesh_share(),
/// read_fields_share()); no rank holds more then. Else rank 0 reads all and deals it out, which is among the
/// warnings; a mesh that is to be mended rank 0 prepares whole. `interrupt`: once set on a
/// rank, the metric is left as it is (make_log_metric()); null: never. Throws meshing::InputError alike on
/// all ranks.
SliceInput read_slice(partition::Peers& peers, const Files& files, const Options& options,
                      const std::shared_ptr<const meshing::Model>& model,
                      const std::atomic<bool>* interrupt = nullptr);

/// All ranks: fields at the points of all slices on rank 0; elsewhere none.
Fields gather_to_first(partition::Peers& peers, const Fields& mine);

}  // namespace weft::tools
