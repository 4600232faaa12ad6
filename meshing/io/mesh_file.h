// Reads and writes meshes and solutions in the format that the file's extension names.
#pragma once

#include <filesystem>

#include "meshing/mesh_data.h"

namespace weft::meshing {

// All of these throw InputError for an unknown extension, a missing file, and bad or unwritable data.

/// Reads .meshb or .mesh.
MeshData read_mesh(const std::filesystem::path& path);

/// Reads .solb or .sol.
SolutionData read_solution(const std::filesystem::path& path);

/// Writes .meshb, .mesh or .vtu. Fields go into the .vtu itself; beside a .meshb or .mesh, whose format
/// cannot hold them, into a .solb or .sol of the same name.
void write_mesh(const std::filesystem::path& path, const MeshData& mesh,
                const SolutionData* fields = nullptr);

/// Writes .solb or .sol.
void write_solution(const std::filesystem::path& path, const SolutionData& solution);

}  // namespace weft::meshing
