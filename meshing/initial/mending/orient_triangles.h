// Loose triangles turned so that they look out of the volumes that they bound.
#pragma once

#include <atomic>
#include <span>
#include <vector>

#include "meshing/initial/clean_triangles.h"

namespace weft::meshing {

/// Triangles on both sides of an edge that only they have are turned alike. What is closed, or nearly so,
/// looks outwards then; within another such shell inwards, because it bounds a hole; and so in turn. Shells
/// that touch or cross (`crossings`) count as one, but for those that looked inwards within another: they
/// are its holes. Other sheets keep the side that most of their area had. Returns which were turned. Throws
/// Interrupted once the flag, if any, is set.
std::vector<bool> orient_triangles(const std::vector<Point>& points, LooseTriangles& triangles,
                                   std::span<const std::array<std::uint32_t, 2>> crossings,
                                   const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::meshing
