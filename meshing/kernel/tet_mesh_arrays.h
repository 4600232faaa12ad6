// The kernel's mesh as plain vectors: what is left of it on its way to another process.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// Everything but capacities and what can be computed again (neighbours): one entry a slot, dead ones too, so
/// that what is done with the mesh afterwards does not depend on whether it has travelled. What nobody reads
/// of dead ones repeats the entry before, which packs well.
struct TetMeshArrays {
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::array<std::uint32_t, 4>> patches;  ///< PatchId values
  std::vector<std::int32_t> tet_refs;
  std::vector<float> qualities;  ///< cached
  std::vector<std::uint8_t> tet_marks;
  std::vector<Point> points;
  std::vector<LogMetric> log_metrics;
  std::vector<std::uint64_t> labels;
  std::vector<std::int32_t> vertex_refs;
  std::vector<std::uint32_t> vertex_tets;  ///< TetId values, invalid for a dead vertex
  std::vector<std::uint32_t> background_hints, surface_hints;
  std::vector<std::uint8_t> kinds, flags, vertex_marks;
  std::vector<TetMesh::FeatureEdge> features;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(tets, patches, tet_refs, qualities, tet_marks, points, log_metrics, labels, vertex_refs,
            vertex_tets, background_hints, surface_hints, kinds, flags, vertex_marks, features);
  }
};

TetMeshArrays to_arrays(const TetMesh& mesh);

/// Room for as many entities as the capacities say. Faces of two tets are glued.
std::unique_ptr<TetMesh> from_arrays(const TetMeshArrays& arrays, std::size_t vertex_capacity,
                                     std::size_t tet_capacity, Pages pages);

}  // namespace weft::meshing
