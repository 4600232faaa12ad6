// UGRID meshes of AFLR3, FUN3D and refine (.ugrid); what stands before the extension names the encoding.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

// NAME.lb8.ugrid and NAME.b8.ugrid are binary, little- and big-endian; .lb8l and .b8l have 64-bit integers,
// .lb4 and .b4 32-bit reals. NAME.ugrid is ASCII.

/// Reads tets and triangles; the references of triangles are the surface IDs, with names where NAME.mapbc
/// lies beside the file; those of tets the volume IDs, where it has them. Other elements are dropped. Throws
/// InputError.
MeshContents read_ugrid(const std::filesystem::path& path);

/// How many points and tets a binary file has; nothing for ASCII, of which no range can be found.
std::optional<MeshSize> ugrid_size(const std::filesystem::path& path);

/// The points and tets of `range`, all triangles and all names, as read_ugrid() reads them; indices are those
/// of the whole mesh. Of a binary file; reads no more of it.
MeshContents read_ugrid_range(const std::filesystem::path& path, const MeshRange& range);

/// Writes tets, triangles and their references, whole or not at all.
void write_ugrid(const std::filesystem::path& path, const MeshView& contents,
                 const WriteOptions& options = {});

/// Whether the name is that of a file which several writers can write, each its part: binary, 64-bit reals.
bool is_ugrid_for_parts(const std::filesystem::path& path);

/// Writes part of such a file, whose bytes are those of write_ugrid() when all have written. Numbers of
/// points are 0-based in the whole mesh. Throws InputError when writing fails.
class UgridSliceWriter {
 public:
  /// Of the whole mesh.
  struct Counts {
    std::uint64_t points = 0, triangles = 0, tets = 0;
    bool tet_refs = false;  ///< any is not 0
  };

  /// `file` exists, and becomes `name` when all have written. Throws InputError where `name` cannot hold so
  /// many.
  UgridSliceWriter(const std::filesystem::path& file, const std::filesystem::path& name,
                   const Counts& counts);
  ~UgridSliceWriter();

  /// All that is no row: to be written by one of the writers.
  void frame();
  // Rows from `first` on.
  void points(std::uint64_t first, std::span<const Point> points);
  void triangles(std::uint64_t first, std::span<const std::array<std::uint64_t, 3>> triangles,
                 std::span<const std::int32_t> refs);
  void tets(std::uint64_t first, std::span<const std::array<std::uint64_t, 4>> tets,
            std::span<const std::int32_t> refs);
  /// Everything to the disk. Nothing may be written afterwards.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Gives `to`, a mesh with the boundaries of `from`, the .mapbc that lies beside `from`: names and boundary
/// conditions. Does nothing where either is no UGRID file, `from` has none, or `to` has one already.
void copy_mapbc(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace weft::meshing
