// How much of a mesh does not conform to its metric, by what the kernel keeps anyway: one cheap pass.
#pragma once

#include <cstdint>

#include "meshing/kernel/tet_mesh.h"
#include "meshing/metric/expectations.h"

namespace weft::meshing {

struct Nonconforming {
  std::uint64_t tets = 0;         ///< all, for comparison
  std::uint64_t poor_tets = 0;    ///< quality, as cached in the mesh, below kPoorQuality
  std::uint64_t long_edges = 0;   ///< longer than sqrt 2 in the metric, each edge once
  std::uint64_t short_edges = 0;  ///< shorter than 1/sqrt 2

  Nonconforming& operator+=(const Nonconforming& other);
  Nonconforming& operator-=(const Nonconforming& other);  ///< modulo 2^64
  friend bool operator==(const Nonconforming&, const Nonconforming&) = default;
};

/// Of two parts of a mesh.
struct NonconformingParts {
  Nonconforming plain;    ///< tets and edges without a vertex that has the flags
  Nonconforming flagged;  ///< those with one
};

/// Counts all live tets and their edges. `flags`: any of these in a vertex's flags. Lengths by the judges'
/// mean of both ends (edge_length_fast). `one_in`: a power of two: edges are counted only of every n-th
/// vertex (the end with the smaller id), and the counts scaled up.
/// Nobody may change the mesh meanwhile.
NonconformingParts count_nonconforming(const TetMesh& mesh, std::uint8_t flags, std::uint32_t one_in = 1);

}  // namespace weft::meshing
