// Which vertices, faces and edges of the input belong to the geometry, and to what of it: told to those who
// have tets there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/geometry/surface/vertex_kind.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// What a rank knows of the boundary's entities, by the numbers of their vertices in the whole input.
struct BoundaryRecords {
  struct Vertex {
    std::uint32_t number;
    std::uint32_t hint;  ///< meshing::Surface::vertex_hint
    meshing::VertexKind kind;
    std::uint8_t flags;        ///< meshing::VertexFlag
    std::uint16_t unused = 0;  ///< no byte of a message is undefined
  };
  struct Face {
    std::array<std::uint32_t, 3> vertices;  ///< ascending
    meshing::PatchId patch;
  };
  struct Edge {
    std::array<std::uint32_t, 2> vertices;  ///< ascending
    meshing::CurveId curve;
  };
  /// Several of one vertex, of one rank or more, mean the highest kind, all flags and the lowest hint.
  std::vector<Vertex> vertices;
  std::vector<Face> faces;
  std::vector<Edge> edges;
};

/// The entities at some vertices, found by numbers.
class BoundaryIndex {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  /// Of `mine`, which each rank has of some, those between this rank's `vertices` (ascending): records meet
  /// at a home that their lowest vertex decides, and are asked for there. All ranks call together.
  BoundaryIndex(Peers& peers, BoundaryRecords mine, const std::vector<std::uint32_t>& vertices);

  /// Place of a vertex among those that belong to the boundary; kNone for one that does not.
  std::uint32_t vertex(std::uint32_t number) const;

  // By such places:
  meshing::VertexKind kind(std::uint32_t place) const { return records_.vertices[place].kind; }
  std::uint32_t hint(std::uint32_t place) const { return records_.vertices[place].hint; }
  std::uint8_t flags(std::uint32_t place) const { return records_.vertices[place].flags; }

  /// All that have triangles, by numbers of vertices.
  std::span<const BoundaryRecords::Face> faces() const { return records_.faces; }

  // By numbers of vertices:
  /// Patch of a face; invalid where it has no triangle.
  meshing::PatchId patch(std::array<std::uint32_t, 3> face) const;
  /// Curve of an edge; invalid where it is no feature edge.
  meshing::CurveId curve(std::uint32_t a, std::uint32_t b) const;

 private:
  BoundaryRecords records_;  // each list sorted by vertices, each entity once
};

}  // namespace weft::partition
