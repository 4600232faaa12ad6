// Adapts one mesh to a metric on one node: the driver of the shared-memory kernel.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "meshing/adapt/adaptation_state.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/kernel/verdict.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

/// What the user may set. The defaults are right for nearly everyone.
struct AdaptOptions {
  int threads = 1;
  /// How many others of the current TBB arena's `threads` have nothing to do now: asked before each pass,
  /// which they help with. Empty: the adaptation has `threads` of its own.
  std::function<int()> idle_threads;
  double complexity = 0;  ///< of the metric on its background, where the caller knows it; 0: not known
  double ridge_angle_degrees = kRidgeAngle;
  double hausd = 0;  ///< wanted largest distance between the mesh's boundary and the reconstructed surface;
                     ///< 0: 0.1 % of the bounding box diagonal, and at most Patch::detail
  std::shared_ptr<const Model> model;  ///< that the boundary lies on; null: the surface is reconstructed
  bool tets_at_frozen_stay = false;    ///< as in the paper; else only frozen vertices themselves stay
  AllowedOperations allowed = {};
  bool coarsen = true;           ///< a mesh that is far from its metric is made coarse before it is made fine
  bool repair_at_frozen = true;  ///< the last improvement is of poor tets with frozen vertices too
  /// Set from a signal handler or another thread: the run ends soon, with the valid mesh it has.
  const std::atomic<bool>* interrupt = nullptr;
  /// Called, from the calling thread, where an allocation has failed and the mesh is whole: sets `interrupt`.
  /// Empty: std::bad_alloc is thrown.
  std::function<void()> out_of_memory;
  /// The same as `interrupt`, of somebody who has no use for the mesh any more.
  const std::atomic<bool>* abandon = nullptr;
  StateKeeper* states = nullptr;  ///< keeps states to go on from, of a whole mesh; null: none
  /// Goes on from this state of an adaptation of the same input with the same options, on any threads; its
  /// arrays are taken. Null: begins anew.
  AdaptationState* resume = nullptr;
  /// Called from the calling thread, at most a few times a second: stage, share done in [0, 1], tets now.
  std::function<void(const std::string& stage, double done, std::uint64_t tets)> progress;
};

struct AdaptReport {
  std::vector<StageReport> stages;
  OperationCounts counts;  ///< of all stages
  bool interrupted = false;
  bool in_order = false;   ///< what is left of the mesh has the order that it had, with holes
  double share_wrong = 1;  ///< of the tets there were: too long an edge or too poor a shape; 1: not looked at
  double surface_deviation =
      0;             ///< largest distance of a boundary face's centroid to the reconstructed surface
  double hausd = 0;  ///< largest distance that was wanted
  std::vector<SurfaceDemand>
      surface_demands;  ///< where the surface needs shorter edges than the metric asks for
  std::shared_ptr<const ModelAccount> model;  ///< how the result lies on the model; null without one
  double seconds = 0;
  std::vector<std::string> warnings;  ///< e.g. boundary triangles that were missing and have been created
};

/// A background: where the metric is read. Usually the input mesh itself.
struct BackgroundData {
  const MeshData* mesh = nullptr;
  const LogMetricField* log_metrics = nullptr;
};

struct AdaptResult {
  MeshData mesh;
  LogMetricField log_metrics;  ///< the background's metric at the result's vertices
  /// Where the mesh is in the order of the input: of each tet, the tet of the input that it is, none of whose
  /// vertices has moved, or kNoOrigin. Else empty.
  std::vector<std::uint32_t> origins;
  AdaptReport report;
};

/// Adapts `input` to the metric of `background`. Throws InputError (with an empty file name) for a mesh that
/// does not conform. One thread: the same input gives the same bytes. More threads: every result is valid,
/// none need be equal.
AdaptResult adapt(const MeshData& input, const BackgroundData& background, const AdaptOptions& options);

}  // namespace weft::meshing
