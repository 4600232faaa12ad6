// UGRID meshes of AFLR3, FUN3D and refine (.ugrid); what stands before the extension names the encoding.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/io/files/file_part.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/mesh_stream.h"
#include "meshing/io/files/part_writer.h"

namespace weft::meshing {

// NAME.lb8.ugrid and NAME.b8.ugrid are binary, little- and big-endian; .lb8l and .b8l have 64-bit integers,
// .lb4 and .b4 32-bit reals. NAME.ugrid is ASCII.

/// Reads tets and triangles; the references of triangles are the surface IDs, with names where NAME.mapbc
/// lies beside the file; those of tets the volume IDs, where it has them. Other elements are dropped. Throws
/// InputError.
MeshContents read_ugrid(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);

/// The same, but for points and tets, which go to the stream.
MeshContents stream_ugrid(const std::filesystem::path& path, MeshStream& stream);
bool is_ascii_ugrid(const std::filesystem::path& path);

/// How many points and tets a binary file has; nothing for ASCII, of which no range can be found.
std::optional<MeshSize> ugrid_size(const std::filesystem::path& path);

/// What `range` says, and all names, as read_ugrid() reads them; indices are those of the whole mesh. Of a
/// binary file; reads no more of it.
MeshContents read_ugrid_range(const std::filesystem::path& path, const MeshRange& range);

/// Writes tets, triangles and their references, whole or not at all.
void write_ugrid(const std::filesystem::path& path, const MeshView& contents,
                 const WriteOptions& options = {});

bool is_binary_ugrid(const std::filesystem::path& path);
/// Whether the name is that of a file of 32-bit reals.
bool has_ugrid_short_reals(const std::filesystem::path& path);

// A binary file, by several writers: one lays it out and writes all that is no row, then each writes its
// rows. The bytes are those of write_ugrid(), which refuses what 32-bit reals break; here the caller does.
PartPlaces begin_ugrid_parts(const std::filesystem::path& file, const std::filesystem::path& name,
                             const WholeMesh& whole);
std::unique_ptr<PartWriter> open_ugrid_part(PartTarget target, const WholeMesh& whole,
                                            const PartPlaces& places);

// An ASCII file, by several writers: what stands before the rows of each section, and the rows of a part,
// which must outlive it.
std::vector<std::string> ugrid_heads(const WholeMesh& whole);
std::unique_ptr<TextPart> open_ugrid_text_part(const WholeMesh& whole, const MeshPart& part);

/// Whether both are UGRID files and a .mapbc lies beside `from`, names and boundary conditions, and no other
/// one beside `to`.
bool has_mapbc_for(const std::filesystem::path& from, const std::filesystem::path& to);
/// What that .mapbc keeps is not lost.
void leave_to_mapbc(const std::filesystem::path& from, RefNames& names, std::vector<Dropped>& dropped);
/// Gives `to`, a mesh with the boundaries of `from`, that .mapbc, where it has none yet.
void copy_mapbc(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace weft::meshing
