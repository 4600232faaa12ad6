// Reads Gmsh's files (.msh), MSH 2.2 and 4.1, ASCII and binary.
#pragma once

#include <filesystem>
#include <optional>

#include "meshing/io/files/field_stream.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/mesh_stream.h"

namespace weft::meshing {

/// Reads tets, triangles, lines, and points (which become corners), of either version, encoding and byte
/// order. References are physical groups with their names, the first of several; in a dimension without any,
/// the geometric entities. Node data are fields. Other elements, those between partitions, and sections are
/// dropped. Throws InputError naming file, entity and reason.
MeshContents read_gmsh(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);
/// The same without node data and what is dropped of sections, and but for points and tets, which go to the
/// stream. Of nodes tagged 1, 2, 3 ... nothing is kept, of others their tags.
MeshContents stream_gmsh(const std::filesystem::path& path, MeshStream& mesh);
/// The node data alone, value by value: the whole file is passed over, and nothing kept but its triangles,
/// edges and corners, and tags as above. Whether a field has all its values, and what of it is one, its
/// taker knows.
void stream_gmsh_fields(const std::filesystem::path& path, FieldStream& fields);
/// Kinds and names of the node data; passes over all else.
SolutionData gmsh_field_heads(const std::filesystem::path& path);

/// The size of a binary file of version 4.1 without partitions whose nodes are tagged 1, 2, 3 ..., as weft
/// writes them; nothing of another, of which ranges cannot be read. Reads all tags.
std::optional<MeshSize> gmsh_size(const std::filesystem::path& path);
MeshContents read_gmsh_range(const std::filesystem::path& path, const MeshRange& range);

}  // namespace weft::meshing
