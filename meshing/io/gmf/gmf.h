// The Gamma Mesh Format (.meshb, .solb binary; .mesh, .sol ASCII) that refine, Mmg, Omega_h and Gmsh share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "meshing/io/files/coordinates.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

// Binary versions: 1 has 32-bit reals; 2 has 64-bit reals; 3 adds 64-bit file positions; 4 adds 64-bit
// indices. A path with the extension .mesh or .sol is ASCII, any other is binary.

/// Reads a tetrahedral mesh: versions 1 to 4, either byte order, or ASCII. Keeps what MeshData can hold and
/// skips other keywords, of which it counts the elements; volume elements other than linear tetrahedra are
/// refused. Throws InputError naming file, entity (1-based) and reason for anything missing, damaged,
/// duplicated, out of range or not finite. No allocation exceeds a small multiple of the file's size,
/// whatever the file claims.
MeshContents read_gmf(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);
/// The mesh alone.
MeshData read_gmf_mesh(const std::filesystem::path& path, Coordinates wanted = Coordinates::finite);

/// Reads the fields at the vertices (SolAtVertices) likewise. Values may be NaN or infinite: what they mean,
/// and whether that is an error, only the caller knows.
SolutionData read_gmf_solution(const std::filesystem::path& path);

/// Writes a mesh, whole or not at all. Version 0 chooses 2, which every program reads, while the file stays
/// below 2 GiB, else 3, or 4 where a count needs it. Throws InputError when writing fails or an explicit
/// version cannot hold the mesh.
void write_gmf_mesh(const std::filesystem::path& path, const MeshData& mesh, int version = 0);

/// The vertices that one part of a distributed mesh has in common with another one.
struct GmfCommunicator {
  std::int32_t part;                  ///< the other one
  std::vector<std::uint32_t> points;  ///< indices in the part that is written
  std::vector<std::uint64_t> global;  ///< their 0-based numbers in the whole mesh
};

/// Writes one part of a distributed mesh likewise, with ParMmg's sections ParallelVertexCommunicators and
/// ParallelCommunicatorVertices. Text files are the safer choice: the reader of binary communicators in
/// ParMmg's sources never reaches the second section.
void write_gmf_part(const std::filesystem::path& path, const MeshData& mesh,
                    std::span<const GmfCommunicator> communicators, int version = 0);

/// Writes fields at vertices likewise. Field names are lost: the format has none.
void write_gmf_solution(const std::filesystem::path& path, const SolutionData& solution, int version = 0);

}  // namespace weft::meshing
