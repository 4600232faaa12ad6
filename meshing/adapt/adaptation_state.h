// The state of an adaptation between two passes: what it goes on from to the same result.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "meshing/kernel/tet_mesh_arrays.h"
#include "weft/data.h"

namespace weft::meshing {

/// Raised when passes are made in another order: the results of those of before cannot be told then.
inline constexpr int kOrderOfPasses = 2;

/// A pass that is over: all that the order of the later ones depends on.
struct PassResult {
  double value = 0;                       ///< what the pass has returned: changes made, a measure
  std::uint64_t tets = 0, tet_slots = 0;  ///< then
};

/// StageReport of a stage that is over.
struct StageDone {
  std::string name;
  double seconds = 0;
  std::uint64_t vertices = 0, tets = 0;
  OperationCounts counts;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(name, seconds, vertices, tets, counts);
  }
};

/// The mesh, and how the adaptation came to where it is: passes that are over are not made again, their
/// results are told instead, so that limits, rounds and levels become what they were.
struct AdaptationState {
  TetMeshArrays mesh;
  std::vector<PassResult> passes;
  std::vector<StageDone> stages;
  OperationCounts counts;              ///< of the stage that is not over
  double seconds = 0;                  ///< spent in it
  std::vector<std::uint64_t> workers;  ///< how many of the free slots each has: tets, vertices
  std::vector<std::uint32_t> free_tets, free_vertices;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(mesh, passes, stages, counts, seconds, workers, free_tets, free_vertices);
  }
};

/// Where states are kept.
class StateKeeper {
 public:
  virtual ~StateKeeper() = default;
  /// Whether one is wanted now; asked after every pass.
  virtual bool wanted() = 0;
  /// `copy` makes the state, and may throw std::bad_alloc.
  virtual void keep(const std::function<AdaptationState()>& copy) = 0;
};

}  // namespace weft::meshing
