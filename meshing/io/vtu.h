// VTK unstructured grids (.vtu), as ParaView and many solvers read and write them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "meshing/io/mesh_contents.h"

namespace weft::meshing {

/// Reads tets, triangles, lines, and vertices (which become corners): arrays as text, base64 or raw, inline
/// or appended, also compressed with zlib. Integer cell data called ref (or by the names of Gmsh and Medit)
/// are the references; point data are fields. Other cells and cell data are dropped. Throws InputError.
MeshContents read_vtu(const std::filesystem::path& path);

/// Writes the same, whole or not at all: references as cell data `ref` and, where there are any, point data
/// `ref`. Binary (appended raw), compressed, or ASCII. Fields without a name are called field_1, field_2, ...
/// Tensors are put in VTK's order xx yy zz xy yz xz.
void write_vtu(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

/// A .vtu that may be one of several: its points may have numbers that are the same in all of them.
struct VtuPiece {
  MeshContents contents;
  std::vector<std::int64_t> global_ids;  ///< of the points, or none
};
/// The pieces of one .vtu.
std::vector<VtuPiece> read_vtu_pieces(const std::filesystem::path& path);
/// One mesh of several pieces: points with the same global ID, or without IDs at the same place, become one.
MeshContents merge_pieces(std::vector<VtuPiece> pieces);
void write_vtu_piece(const std::filesystem::path& path, const MeshView& contents,
                     const std::vector<std::int64_t>& global_ids, const WriteOptions& options);

}  // namespace weft::meshing
