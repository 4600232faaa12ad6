// The metric that options ask for, made by all ranks together: none holds the whole mesh.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "weft/weft.h"

namespace weft::tools {

/// Whether nothing asks how the metric, a file's or a function's, is elsewhere: every rank can do with its
/// share of the points.
bool only_scaled(const MetricOptions& options);
/// All ranks: that metric at the points of the slice, not scaled. The mesh may have no tets, or inverted
/// ones. Throws alike on all ranks.
meshing::LogMetricField metric_of_share(partition::Peers& peers, const MetricOptions& options,
                                        const partition::MeshSlice& slice);

/// All ranks: make_log_metric() of the mesh of all slices, at the points of this rank's slice; the same bits
/// for any number of ranks and any shares. slice.log_metrics are one more source where there are any;
/// options.solutions are at the points of the slice. Throws alike on all ranks.
LogMetricMade make_metric_in_parts(partition::Peers& peers, const MetricOptions& options,
                                   const partition::MeshSlice& slice, const std::string& mesh_name,
                                   const std::shared_ptr<const meshing::Model>& model,
                                   const std::optional<SurfaceBound>& bound = {},
                                   const std::atomic<bool>* interrupt = nullptr);

/// All ranks: surface_bound() of the mesh of all slices.
std::optional<SurfaceBound> surface_bound_in_parts(partition::Peers& peers, const GeometryOptions& options,
                                                   const partition::MeshSlice& slice);

}  // namespace weft::tools
