// VTK unstructured grids (.vtu), as ParaView and many solvers read and write them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "meshing/io/files/file_part.h"
#include "meshing/io/files/merge_pieces.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/part_writer.h"

namespace weft::meshing {

/// Reads tets, triangles, lines, and vertices (which become corners): arrays as text, base64 or raw, inline
/// or appended, also compressed with zlib. Cell data called ref (or by the names of Gmsh and Medit) are the
/// references if all are whole numbers, in all pieces; point data are fields. Other cells and cell data are
/// dropped. Throws InputError.
MeshContents read_vtu(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);

/// The size of a file with one piece; nothing of one with several. Reads the types of all cells.
std::optional<MeshSize> vtu_size(const std::filesystem::path& path);
MeshContents read_vtu_range(const std::filesystem::path& path, const MeshRange& range);

/// Writes the same, whole or not at all: references as cell data `ref` and, where there are any, point data
/// `ref`. Binary (appended raw), compressed, or ASCII. Fields without a name are called field_1, field_2,
/// ...; of several with one name the second is NAME_2. Tensors are put in VTK's order xx yy zz xy yz xz.
void write_vtu(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options = {});

// Parts of the pieces, of which there may be many (see mesh_file.h).
std::vector<PieceSize> vtu_piece_sizes(const std::filesystem::path& path);
PieceRanges read_vtu_piece_ranges(const std::filesystem::path& path, std::span<const PieceRange> ranges);
std::vector<MeshContents> read_vtu_piece_fields(const std::filesystem::path& path,
                                                std::span<const PieceRange> ranges);

// The same file, neither compressed nor ASCII, by several writers: one lays it out and writes all that is no
// row, then each writes its rows.
PartPlaces begin_vtu_parts(const std::filesystem::path& file, const std::filesystem::path& name,
                           const WholeMesh& whole);
std::unique_ptr<PartWriter> open_vtu_part(PartTarget target, const WholeMesh& whole,
                                          const PartPlaces& places);

// An ASCII file, by several writers: what stands before the rows of each section, and the rows of a part,
// which must outlive it.
std::vector<std::string> vtu_heads(const WholeMesh& whole);
std::unique_ptr<TextPart> open_vtu_text_part(const WholeMesh& whole, const MeshPart& part);

/// A number for every cell: tets, triangles, edges and corners, in this order.
struct CellData {
  std::string name;
  std::vector<double> values;
};

/// What the arrays of fields are called: all different, and not as those of point data that are no fields.
std::vector<std::string> field_array_names(const SolutionData& fields, bool global_ids, bool point_refs);

/// The pieces of each of several .vtu files of one mesh. Where the references of one cannot be those of
/// another all are read once more, without these.
std::vector<std::vector<MeshPiece>> read_vtu_pieces(std::span<const std::filesystem::path> sources,
                                                    Coordinates wanted = Coordinates::finite);
/// A .vtu as one of several, which all have references of points or none. More cell data than `ref` are for
/// viewers: readers here drop them.
void write_vtu_piece(const std::filesystem::path& path, const MeshView& contents,
                     const std::vector<std::int64_t>& global_ids, bool point_refs,
                     const WriteOptions& options, const std::vector<CellData>& cell_data = {});

}  // namespace weft::meshing
