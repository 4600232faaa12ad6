// Coordinates in formats with 32-bit reals.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Throws InputError for `file` naming the first vertex that is too far away for single precision, or the
/// first tet that is positive and would be flat or inverted once its vertices are rounded: what was written
/// could not be read again as a mesh.
void refuse_if_rounding_breaks(const MeshData& mesh, const std::string& file);

/// The same of a part of a mesh: its first point and its first tet have these numbers in the whole mesh, and
/// corners(t) are the points of its tet `t`, also by several threads.
void refuse_if_rounding_breaks(std::span<const Point> points, std::uint64_t first_point, std::size_t num_tets,
                               std::uint64_t first_tet,
                               const std::function<std::array<Point, 4>(std::size_t)>& corners,
                               const std::string& file);

}  // namespace weft::meshing
