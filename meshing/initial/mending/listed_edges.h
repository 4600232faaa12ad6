// Listed edges of a surface that is mended: they follow its triangles, and their pieces are what they were.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Edges that were cut, by their keys (edge_key()), and the vertices on each from its smaller end to the
/// other.
using EdgeCuts = std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>;

class ListedEdges {
 public:
  explicit ListedEdges(const MeshData& surface);

  /// Vertices have become others. Those beyond `now`, and those for which it has
  /// TriangleCleaning::kUnused, stay.
  void renumber(std::span<const std::uint32_t> now);
  /// Returns whether any was cut.
  bool cut(const EdgeCuts& cuts);
  /// Takes the place of the edges of the surface that they are of. Pieces have the reference and the marks of
  /// their edge; of those at the same place the first stays, with the marks of all.
  void give_to(MeshData& surface) const;

 private:
  struct Piece {
    std::array<std::uint32_t, 2> ends;
    std::uint32_t edge;  ///< its number in the surface
  };
  std::vector<Piece> pieces_;
};

}  // namespace weft::meshing
