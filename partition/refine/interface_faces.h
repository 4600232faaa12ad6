// The faces of a subdomain's interface and their edges while edges are split: the faces at an edge are known
// without a search.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/kernel/tet_mesh.h"

namespace weft::partition {

/// Faces whose other tet is in another subdomain, with their edges. An edge usually has two of these faces,
/// more where the subdomain touches itself. Valid as long as the mesh changes only by the splits reported to
/// split().
class InterfaceFaces {
 public:
  using EdgeIndex = std::uint32_t;

  /// `patch_inner`: as in Geometry.
  InterfaceFaces(const meshing::TetMesh& mesh, const std::vector<bool>& patch_inner);

  std::uint32_t num_edges() const { return static_cast<std::uint32_t>(edges_.size()); }
  std::array<meshing::VertexId, 2> ends(EdgeIndex e) const { return edges_[e].ends; }
  /// The faces at an edge, in a fixed order, after what is in `faces`.
  void append_faces(EdgeIndex e, std::vector<meshing::TetFace>& faces) const;

  /// The mesh has split edge e at m: the tets around it, `tets`, have kept the end `kept`, each with its
  /// local places, and the tet across its face opposite `kept` is the other half
  /// (meshing/operators/split_edge.h). The two halves of e, and an edge in each of its faces, come to the end
  /// of the list of edges; e has no faces any more.
  void split(EdgeIndex e, meshing::VertexId kept, meshing::VertexId m, std::span<const meshing::TetId> tets);

 private:
  using FaceIndex = std::uint32_t;
  using Side = std::uint32_t;  ///< 3 * face + i: from the face's vertex i to the next
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  struct Edge {
    std::array<meshing::VertexId, 2> ends;
    Side first = kNone, last = kNone;
  };

  bool is_interface(meshing::TetFace face) const;
  meshing::VertexId vertex(FaceIndex f, int place) const;
  FaceIndex index_of(meshing::TetFace face) const;
  void set_index(meshing::TetFace face, FaceIndex f);
  FaceIndex add_face(meshing::TetFace face);
  EdgeIndex add_edge(meshing::VertexId a, meshing::VertexId b);
  void find_edges();
  void append(Side side, EdgeIndex e);
  void replace(Side old, Side by);
  void follow_face_beyond(meshing::TetId t, meshing::VertexId kept);
  void split_face(Side side, meshing::VertexId kept, meshing::VertexId m, std::array<EdgeIndex, 2> halves);

  const meshing::TetMesh& mesh_;
  const std::vector<bool>& patch_inner_;
  std::vector<meshing::TetFace> faces_;
  std::vector<FaceIndex> index_of_;  ///< by TetFace::code, kNone for faces that are none of the interface
  std::vector<Edge> edges_;
  std::vector<EdgeIndex> edge_of_;  ///< by side
  std::vector<Side> next_;          ///< by side: the next one at its edge
};

}  // namespace weft::partition
