// A piece's part of the whole mesh, in the numbers of the whole mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "meshing/io/gmf/gmf_slice_writer.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/output/numbering.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// What a piece contributes besides its tets: its own entities (PieceShare), in its order, by numbers of the
/// whole mesh. Their own numbers count on from PieceNumbers::first.
struct OwnEntities {
  std::vector<meshing::Point> points;
  std::vector<std::int32_t> point_refs;
  std::vector<std::array<std::uint64_t, 3>> triangles;
  std::vector<std::int32_t> triangle_refs;
  std::vector<std::array<std::uint64_t, 2>> edges;
  std::vector<std::int32_t> edge_refs;
  std::vector<std::uint64_t> corners, required_points;  ///< numbers of points
  std::vector<std::uint64_t> ridges, required_edges;    ///< numbers of edges
  std::vector<std::uint64_t> required_triangles;        ///< numbers of triangles
  std::vector<meshing::gmf::ModelRow> on_nodes, on_edges, on_faces;
};

OwnEntities own_entities(const MeshPiece& piece, const PieceNumbers& numbers);
/// Metrics of its own points.
meshing::LogMetricField own_log_metrics(const MeshPiece& piece, const PieceNumbers& numbers);
/// Some of the tets, all of which are its own, with the references of the piece.
std::vector<std::array<std::uint64_t, 4>> own_tets(const MeshPiece& piece, const PieceNumbers& numbers,
                                                   std::size_t first, std::size_t count);
inline std::vector<std::array<std::uint64_t, 4>> own_tets(const MeshPiece& piece,
                                                          const PieceNumbers& numbers) {
  return own_tets(piece, numbers, 0, piece.mesh.tets.size());
}

}  // namespace weft::partition
