// CGNS files (.cgns) through the CGNS library, in HDF5.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "meshing/io/files/file_part.h"
#include "meshing/io/files/merge_pieces.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/part_writer.h"

namespace weft::meshing {

/// Reads the unstructured zones of the first base (several are joined where their points coincide): tets,
/// triangles and bars. References are given to names: of boundary conditions at faces, else of sections.
/// Solutions at vertices are fields (NAMEX, NAMEY, NAMEZ are a vector). Other elements and nodes of CGNS are
/// dropped. Throws InputError.
MeshContents read_cgns(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);

/// How many points and tets there are; nothing for a file of several zones. Passes over sections of mixed
/// elements, in blocks.
std::optional<MeshSize> cgns_size(const std::filesystem::path& path);

/// What `range` says, and all names, as read_cgns() reads them, but no fields; indices are those of the whole
/// mesh. Of a file that cgns_size() has sized; reads no more of it but all triangles and edges, and
/// passes over sections of mixed elements, in blocks.
MeshContents read_cgns_range(const std::filesystem::path& path, const MeshRange& range);

// Parts of the zones (see mesh_file.h). Names and their references are those of the whole file on every
// reader, who reads all elements that are no tets for them.
std::vector<PieceSize> cgns_piece_sizes(const std::filesystem::path& path);
PieceRanges read_cgns_piece_ranges(const std::filesystem::path& path, std::span<const PieceRange> ranges);
std::vector<MeshContents> read_cgns_piece_fields(const std::filesystem::path& path,
                                                 std::span<const PieceRange> ranges);

/// Writes one zone, whole or not at all: a section for each reference, and for triangles a boundary condition
/// of the same name; names are cut to CGNS's 32 characters.
void write_cgns(const std::filesystem::path& path, const MeshView& contents,
                const WriteOptions& options = {});

// The same file by several writers: one lays it out, then each writes its rows. (Bytes beside the rows are
// not always the same: HDF5 notes the time.)
PartPlaces begin_cgns_parts(const std::filesystem::path& file, const std::filesystem::path& name,
                            const WholeMesh& whole);
std::unique_ptr<PartWriter> open_cgns_part(PartTarget target, const WholeMesh& whole,
                                           const PartPlaces& places);

}  // namespace weft::meshing
