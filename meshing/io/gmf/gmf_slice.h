// Parts of a GMF file: what one of many ranks reads of a mesh that none of them holds whole.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/mesh_stream.h"
#include "meshing/io/gmf/gmf_format.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

// All functions here accept what read_gmf_mesh and read_gmf_solution do, report errors in the same words, and
// check of the rows those that they read. Of binary files only the part asked for is read; text files are
// scanned from the first row of a section on. Nothing larger than the part is allocated. Rows that the
// layout does not have throw std::out_of_range; a file whose size has changed since, InputError.

/// The keywords of a mesh or a solution file, checked against the size of the file.
GmfLayout read_gmf_layout(const std::filesystem::path& path);

/// Arrays of one entry a vertex.
struct GmfPoints {
  std::vector<Point> points;
  std::vector<std::int32_t> refs;
};
/// The vertices `first` (0-based) to `first + count - 1`.
GmfPoints read_gmf_points(const std::filesystem::path& path, const GmfLayout& layout, std::uint64_t first,
                          std::uint64_t count);

/// Arrays of one entry a tet; vertices by their 0-based number in the whole mesh.
struct GmfTets {
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::int32_t> refs;
};
GmfTets read_gmf_tets(const std::filesystem::path& path, const GmfLayout& layout, std::uint64_t first,
                      std::uint64_t count);

/// The range's part of triangles, edges, corners, ridges, what is required and the records of vertices on a
/// CAD model, by numbers in the whole mesh; neither points nor tets.
MeshData read_gmf_boundary(const std::filesystem::path& path, const GmfLayout& layout,
                           const MeshRange& range = {});

/// What read_gmf() returns but for points, tets and a CAD model: points and tets go to the stream.
MeshContents stream_gmf(const std::filesystem::path& path, MeshStream& stream);

/// The CAD model that the file carries, none of the records; empty where it has none.
Association read_gmf_model(const std::filesystem::path& path, const GmfLayout& layout);

/// The values of all fields at the vertices `first` to `first + count - 1`; num_points is `count`.
SolutionData read_gmf_solution_slice(const std::filesystem::path& path, const GmfLayout& layout,
                                     std::uint64_t first, std::uint64_t count);

}  // namespace weft::meshing
