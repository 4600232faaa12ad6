// The metric that options ask for, made by all ranks together: none holds the whole mesh.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "weft/weft.h"

namespace weft::tools {

/// All ranks: the metric of a file at the points of the slice. Throws alike on all ranks.
meshing::LogMetricField metric_of_slice(partition::Peers& peers, const std::string& file,
                                        const partition::MeshSlice& slice);

/// All ranks: make_log_metric() of the mesh of all slices, at the points of this rank's slice; the same bits
/// for any number of ranks and any shares. slice.log_metrics are one more source where there are any;
/// options.solutions are at the points of the slice. Throws alike on all ranks.
LogMetricMade make_metric_in_parts(partition::Peers& peers, const MetricOptions& options,
                                   const partition::MeshSlice& slice, const std::string& mesh_name,
                                   const std::shared_ptr<const meshing::Model>& model,
                                   const std::optional<SurfaceBound>& bound = {});

/// All ranks: surface_bound() of the mesh of all slices.
std::optional<SurfaceBound> surface_bound_in_parts(partition::Peers& peers, const GeometryOptions& options,
                                                   const partition::MeshSlice& slice);

}  // namespace weft::tools
