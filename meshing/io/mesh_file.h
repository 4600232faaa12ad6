// Reads and writes meshes and solutions in the format that the file's extension names.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "meshing/io/files/field_stream.h"
#include "meshing/io/files/file_part.h"
#include "meshing/io/files/merge_pieces.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/mesh_stream.h"
#include "meshing/io/files/part_writer.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

// All of these throw InputError for an unknown extension, a missing file, and bad or unwritable data.

/// Reads a mesh of any format that mesh_extensions() lists. A file with volume elements other than linear
/// tetrahedra is refused; whatever else has no place in a MeshData is left out. `names` gets the names of
/// references.
MeshData read_mesh(const std::filesystem::path& path, RefNames* names = nullptr,
                   Coordinates wanted = Coordinates::finite);

/// Reads everything, and says what it had to leave out: also volume elements that are no tetrahedra.
MeshContents read_mesh_contents(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);

/// What is done with a mesh that has volume elements other than linear tetrahedra.
enum class OtherVolumes { refused, dropped };

/// How many points and tets a file has of which ranges can be read: GMF, binary UGRID, CGNS of one zone,
/// .vtu of one piece, binary .msh 4.1 with nodes tagged in order. Nothing for any other.
std::optional<MeshSize> size_for_ranges(const std::filesystem::path& path);

/// Part of such a file: what `range` says, with indices of the whole mesh, and all names; no fields. Reads
/// (but of text) and allocates no more; of .vtu the types of all cells, and of CGNS one list of a boundary
/// condition at a time. Refuses what read_mesh refuses, as far as it reads it.
MeshContents read_mesh_range(const std::filesystem::path& path, const MeshRange& range,
                             OtherVolumes others = OtherVolumes::refused);

/// Whether the mesh of such a file may be in several pieces, of which points must be joined (merge_pieces()):
/// .pvtu, .vtu and .cgns.
bool can_be_in_pieces(const std::filesystem::path& path);
/// The files that have the pieces, in this order: those that a .pvtu names, else the file itself.
std::vector<std::filesystem::path> piece_sources(const std::filesystem::path& path);
/// The pieces of one of these. Reads the types of all cells of a .vtu, and passes over sections of mixed
/// elements of a .cgns.
std::vector<PieceSize> piece_sizes(const std::filesystem::path& source);
/// Parts of the pieces: one range for each of them, or of the fields for the first ones.
PieceRanges read_piece_ranges(const std::filesystem::path& source, std::span<const PieceRange> ranges);
/// Fields at the points of the ranges, of each piece, and an account of what is no field here, no more; those
/// that cannot be kept, as only the values show, have no values.
std::vector<MeshContents> read_piece_fields(const std::filesystem::path& source,
                                            std::span<const PieceRange> ranges);

/// Kinds and names of the fields that a volume mesh file itself holds, of several pieces those of the first;
/// no values.
SolutionData field_heads(const std::filesystem::path& path);

/// Throws where a mesh has so many volume elements that are no linear tetrahedra, but none.
void refuse_foreign_volumes(std::uint64_t count, const std::filesystem::path& path);

/// Whether one reader can pass the points and tets of such a file on while it reads, and holds none: GMF as
/// text, .msh of which no ranges can be read, .su2, ASCII UGRID.
bool can_be_streamed(const std::filesystem::path& path);
/// What read_mesh() and its `names` would be, but for points and tets, which go to the stream. No fields.
MeshContents stream_mesh(const std::filesystem::path& path, MeshStream& stream,
                         OtherVolumes others = OtherVolumes::refused);

/// Whether one reader can pass the fields of such a mesh file on while it reads, and holds none: .msh.
bool can_stream_fields(const std::filesystem::path& path);
/// All of them. What of read_solution() is no field the stream is told too.
void stream_fields(const std::filesystem::path& path, FieldStream& fields);

/// The CAD model that a mesh file carries, without the records of vertices on it; empty where it has none.
Association read_carried_model(const std::filesystem::path& path);

/// Whether a mesh file says how its vertices lie on a CAD model, or carries one.
bool has_association(const std::filesystem::path& path);

/// Reads .solb or .sol, or the fields in a mesh file that has some.
SolutionData read_solution(const std::filesystem::path& path);

/// Writes a mesh. Fields go into the file itself where its format holds them (holds_fields); beside any other
/// into a .solb of the same name, or a .sol beside a .mesh.
void write_mesh(const std::filesystem::path& path, const MeshData& mesh,
                const SolutionData* fields = nullptr);

/// Writes mesh, fields and names as far as the format holds them.
void write_mesh_contents(const std::filesystem::path& path, const MeshView& contents,
                         const WriteOptions& options = {});

/// Whether several writers can write the file, each its part of the mesh: binary UGRID, .msh, .vtu, .cgns.
/// (GMF files have a writer of their own, GmfSliceWriter.) `options`: WholeMesh::options.
bool can_be_written_in_parts(const std::filesystem::path& path, const WriteOptions& options = {});
/// By one of the writers, before the others: lays the file out, and writes all that is no row. `file` exists,
/// and becomes `name` when all have written: the bytes are those of write_mesh_contents().
PartPlaces begin_parts(const std::filesystem::path& file, const std::filesystem::path& name,
                       const WholeMesh& whole);
/// By every writer, the target's name that of the file; `places` is what the first has got of begin_parts().
std::unique_ptr<PartWriter> open_part(PartTarget target, const WholeMesh& whole, const PartPlaces& places);
/// Whether such a file has 32-bit reals: who writes a part asks refuse_if_rounding_breaks() of it first.
bool has_short_reals(const std::filesystem::path& path);

/// The same of text, whose rows have no places until their length is known: whether several writers can write
/// the file, section by section.
bool can_be_written_as_text(const std::filesystem::path& path, const WriteOptions& options = {});
/// What stands before the rows of each section of such a file; it is followed by the rows (TextPart) of all
/// parts in their order: the bytes are those of write_mesh_contents().
std::vector<std::string> text_heads(const std::filesystem::path& name, const WholeMesh& whole);
/// `whole` and `part` must outlive it.
std::unique_ptr<TextPart> open_text_part(const std::filesystem::path& name, const WholeMesh& whole,
                                         const MeshPart& part);

/// The same of a file whose arrays are compressed in blocks (VtuBlocks): .vtu.
bool can_be_written_in_blocks(const std::filesystem::path& path, const WriteOptions& options);

/// How much a mesh has of what formats may have no place for.
struct ContentCounts {
  std::uint64_t tets = 0, edges = 0, corners = 0, ridges = 0;
  std::uint64_t required_points = 0, required_edges = 0, required_triangles = 0;
  std::uint64_t point_refs = 0, tet_refs = 0;  ///< that are not 0
  std::uint64_t on_model = 0, models = 0;      ///< records of vertices on a CAD model
};
ContentCounts counts_of(const MeshData& mesh);
std::uint64_t count_nonzero(const std::vector<std::int32_t>& refs);

/// What write_mesh_contents would leave out. Fields (their values are not looked at) do not count where they
/// can go into a file beside.
std::vector<Dropped> lost_in(const std::filesystem::path& path, const ContentCounts& mesh,
                             const SolutionData& fields, const RefNames& names,
                             const WriteOptions& options = {});

/// Writes .solb or .sol.
void write_solution(const std::filesystem::path& path, const SolutionData& solution);

/// The solution file that belongs beside a mesh file: OUT.sol for OUT.mesh, else OUT.solb.
std::filesystem::path solution_beside(const std::filesystem::path& mesh);

/// Throws InputError where files of this name need a part of weft that is missing (see load_part.h).
void require_part(const std::filesystem::path& path);
/// Whether the name's extension is that of a mesh format.
bool is_mesh_name(const std::filesystem::path& path);
/// Whether the format keeps all points of a mesh, so that fields in a file beside it still fit.
bool holds_volumes(const std::filesystem::path& path);
/// Whether the format keeps fields in the mesh file itself.
bool holds_fields(const std::filesystem::path& path);
/// ".meshb, .mesh, .stl or .obj", for messages.
std::string mesh_extensions();
/// Those of formats that hold tets.
std::string volume_extensions();

}  // namespace weft::meshing
