// What boundary and interfaces of an input are made of, by one rule for whole meshes and for meshes in
// pieces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Copies the edges of `input` that are sides of `boundary.triangles`, with their marks: the kernel tracks
/// features of the boundary only. Numbers of points are the same in both. Warns of those that are dropped.
void take_boundary_edges(const MeshData& input, MeshData& boundary, std::vector<std::string>& warnings);

/// Lists those of the input's required triangles that have a new index: `new_index` of dropped ones is
/// kDropped.
inline constexpr std::uint32_t kDropped = 0xFFFFFFFFu;
void take_required_triangles(const MeshData& input, const std::vector<std::uint32_t>& new_index,
                             MeshData& boundary);

/// What a user is told, in the same words whoever finds it.
std::string repeated_triangles_warning(std::size_t count);
std::string created_triangles_warning(std::size_t count);
std::string dropped_edges_warning(std::size_t count);
std::string triangle_name(std::uint64_t index, const Triangle& vertices);
inline constexpr const char* kIsNoFace = "is not a face of any tet";
/// Of two tets on the same side of a face.
inline const char* overlap_reason(bool same_vertices) {
  return same_vertices ? "are duplicates" : "overlap: they lie on the same side of their common face";
}

}  // namespace weft::meshing
