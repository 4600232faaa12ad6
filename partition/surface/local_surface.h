// A rank's triangles of the boundary with two rings of others around them.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/surface/boundary_share.h"

namespace weft::partition {

/// Vertices and triangles have the order that they have in the boundary.
struct LocalSurface {
  meshing::MeshData mesh;                ///< numbered by entries of `vertices`
  std::vector<std::uint32_t> triangles;  ///< numbers in the boundary, ascending
  std::vector<std::uint32_t> vertices;   ///< numbers in the whole input, ascending
  std::vector<std::uint8_t> rings;       ///< meshing::SurfaceTopology::rings
  std::vector<std::uint32_t> owners;     ///< ranks that own the triangles
};

/// Finds the triangles around others: at the homes of their vertices, which are told of all that are there.
class SurfaceNeighbours {
 public:
  /// Each rank owns the triangles of its share. Refers to its arguments. All ranks call together, also what
  /// follows.
  SurfaceNeighbours(Peers& peers, const BoundaryShare& share, const FetchPoints& points);

  /// With these triangles as its own, each once. Of edges and lists it has what lies between its vertices. On
  /// one rank `own` must be all.
  LocalSurface around(std::vector<BoundaryTriangle> own) const;

 private:
  struct Owned {
    BoundaryTriangle triangle;
    std::uint32_t owner;
  };

  void send_home();
  std::vector<Owned> at(const std::vector<std::uint32_t>& vertices) const;
  std::vector<BoundaryEdge> edges_from(const std::vector<std::uint32_t>& vertices) const;
  void add_edges(LocalSurface& local) const;

  Peers& peers_;
  const BoundaryShare& share_;
  const FetchPoints& points_;
  std::vector<Owned> here_;                                         // with a vertex whose home this is
  std::vector<std::pair<std::uint32_t, std::uint32_t>> at_vertex_;  // (vertex, place in here_), sorted
};

}  // namespace weft::partition
