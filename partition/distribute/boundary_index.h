// Which vertices, faces and edges of the input belong to the geometry, and to what of it.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/geometry/surface.h"
#include "partition/distribute/whole_boundary.h"
#include "partition/subdomain/geometry.h"

namespace weft::partition {

/// Finds entities by the numbers of their vertices in the whole input. Refers to its arguments' data.
class BoundaryIndex {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  BoundaryIndex(const WholeBoundary& boundary, const Geometry& geometry);

  /// Index of a vertex among the boundary's points; kNone for one that nothing is known of.
  std::uint32_t vertex(std::uint32_t number) const;

  // By indices of vertices; all of these vertices must be known.
  meshing::VertexKind kind(std::uint32_t vertex) const { return geometry_.surface.vertex_kind(vertex); }
  std::uint32_t hint(std::uint32_t vertex) const { return geometry_.surface.vertex_hint(vertex); }
  std::uint8_t flags(std::uint32_t vertex) const { return flags_[vertex]; }
  /// Patch of a face; invalid where it has no triangle.
  meshing::PatchId patch(std::array<std::uint32_t, 3> face) const;
  /// Curve of an edge; invalid where it is no feature edge.
  meshing::CurveId curve(std::uint32_t a, std::uint32_t b) const;

 private:
  using Face = std::array<std::uint32_t, 3>;
  void set_flags();

  const WholeBoundary& boundary_;
  const Geometry& geometry_;
  std::vector<std::uint8_t> flags_;                       // meshing::VertexFlag
  std::vector<std::pair<Face, meshing::PatchId>> faces_;  // vertices ascending; sorted
  std::vector<meshing::Surface::FeatureEdge> edges_;      // sorted by vertices
};

}  // namespace weft::partition
