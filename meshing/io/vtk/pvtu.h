// Parallel VTK unstructured grids (.pvtu): an index of .vtu pieces.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Reads all pieces as one mesh. Points are the same where their global IDs are (point data that PointData
/// names as GlobalIds, or called GlobalPointIds), without IDs where their coordinates are. Ghost cells are
/// left out.
MeshContents read_pvtu(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);

/// The files of the pieces, in the order of the index.
std::vector<std::filesystem::path> pvtu_sources(const std::filesystem::path& path);

/// The same with the numbers of the pieces, in the order of the index from 0, as references of the tets.
MeshContents read_pvtu_by_piece(const std::filesystem::path& path);

/// Writes NAME_0.vtu, NAME_1.vtu, ... beside NAME.pvtu, the index last: tets, triangles and edges in equal
/// shares of their order, points with global IDs.
void write_pvtu(const std::filesystem::path& path, const MeshView& contents,
                const WriteOptions& options = {});

/// The index alone, of pieces that write_vtu_piece wrote: files named relative to the index, all with the
/// same point fields (their kinds and names count, not their values), all with references of points or none,
/// and the same cell data beside `ref`.
void write_pvtu_index(const std::filesystem::path& path, const SolutionData& fields, bool point_refs,
                      const std::vector<std::string>& cell_data, const std::vector<std::string>& pieces);

}  // namespace weft::meshing
