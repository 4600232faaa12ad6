// Result files: checked before the work starts, and complete or absent after it.
#pragma once

#include <string>
#include <vector>

#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/mesh_file.h"

namespace weft::tools {

/// A mesh file and the files beside it: OUT.mesh has OUT.sol and OUT-fields.sol, any other OUT.solb and
/// OUT-fields.solb; a .pvtu has none, its pieces hold all.
struct OutputPaths {
  std::string mesh;
  std::string solution;     ///< the metric
  std::string fields = {};  ///< those carried along
};
OutputPaths output_paths(const std::string& mesh);

/// Throws InputError unless a file can be created at `path`, and what writes a mesh format is there.
void check_writable(const std::string& path);
/// Creates the folder and its parents; throws InputError when that fails.
void make_folder(const std::string& path);

/// Writes the mesh and, beside it, the solution and, where there are any, the fields; these appear only once
/// the mesh has. A format that holds fields gets all of them into the mesh file too.
void write_mesh_with_solution(const OutputPaths& paths, const meshing::MeshData& mesh,
                              const meshing::SolutionData& solution, const meshing::SolutionData& fields = {},
                              const meshing::RefNames& names = {});

/// Writes the mesh with the fields: in its file where the format holds them, else in the one beside.
void write_mesh_and_fields(const std::string& path, const meshing::MeshData& mesh,
                           const meshing::SolutionData& fields, const meshing::RefNames& names);

/// Warnings of what the file will not keep of the content of the file `from`. Where its vertices' records on
/// a CAD model are not made anew (`on_model`), of these too.
std::vector<std::string> loss_warnings(const std::string& mesh, const std::string& from,
                                       meshing::ContentCounts input, const meshing::RefNames& names,
                                       bool on_model);

/// Writes beside, then renames.
void write_text(const std::string& path, const std::string& text);

}  // namespace weft::tools
