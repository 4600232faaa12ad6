// What writers of common files have to know of the whole mesh, and where the entities of each piece go.
#pragma once

#include <span>
#include <vector>

#include "meshing/io/files/part_writer.h"
#include "partition/output/numbering.h"

namespace weft::partition {

/// Numbers of the first of a piece's own entities among those of the whole mesh with the same reference.
struct FirstWithRef {
  meshing::RefCounts tets, triangles, edges;
};

struct DescribedMesh {
  meshing::WholeMesh whole;
  std::vector<FirstWithRef> pieces;  ///< in the order of the pieces given
};

/// All ranks: whether a vertex of any piece has a reference other than 0.
bool have_point_refs(Peers& peers, std::span<const MeshPiece> mine);

/// All ranks: describes the mesh of all pieces, numbered by `numbering`, as meshing::describe() does with the
/// merged mesh; without names and fields.
DescribedMesh describe_pieces(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering);

}  // namespace weft::partition
