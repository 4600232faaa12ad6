// A surface that bounds volumes: cleaned and checked triangles to make an initial mesh from.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

struct SurfaceChecks {
  double merge_tolerance = 1e-9;  ///< of the bounding box diagonal: points nearer than this are one
  /// Of each triangle of a mended surface: its number before, for messages and for ClosedSurface; else empty.
  std::vector<std::uint32_t> source = {};
};

/// Triangles without free edges, duplicates, degenerate ones and self-intersections. More than two triangles
/// may meet at an edge, where several volumes do.
struct ClosedSurface {
  /// Points, triangles with references, and what edges, corners and required entities were listed; no tets.
  MeshData mesh;
  std::vector<std::uint32_t> source;  ///< of each triangle: its number in the input, or SurfaceChecks::source
  std::vector<std::string> warnings;  ///< what was mended
};

/// Takes the triangles of `input` (its tets, if any, are left out). Mends: points that nearly coincide are
/// merged, triangles that collapse then are dropped, those whose height is below the tolerance swapped with
/// the neighbour on their longest edge, repeated ones (the common face of two touching solids) merged. Pieces
/// of listed edges and of required triangles are listed in their place.
/// Orientation is not looked at. Throws InputError (no file name), naming triangles of the input (1-based),
/// for a surface that is empty, open, or intersects itself.
ClosedSurface close_surface(const MeshData& input, const SurfaceChecks& checks);

}  // namespace weft::meshing
