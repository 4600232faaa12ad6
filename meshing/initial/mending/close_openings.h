// Openings of a surface closed where its winding number says that the volume ends.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/initial/clean_triangles.h"
#include "meshing/initial/mending/listed_edges.h"

namespace weft::meshing {

/// A closed surface made of an open one.
struct ClosedOpenings {
  std::vector<Point> points;  ///< those given, then new ones
  LooseTriangles triangles;   ///< closing ones have the source of a triangle beside them
  std::vector<bool> closing;  ///< of each triangle: whether it is new
  EdgeCuts cuts;              ///< of the given triangles' edges
};

/// `triangles` must not cross, and look outwards. Tets are made of all their points, with the triangles as
/// faces; those behind a triangle are inside, those in front of it outside, and the winding number decides on
/// the others. Faces between inside and outside are the result. Throws InputError where tets cannot be made,
/// with the triangle's number of `numbers`; Interrupted once the flag, if any, is set.
ClosedOpenings close_openings(const std::vector<Point>& points, const LooseTriangles& triangles,
                              std::span<const std::uint32_t> numbers,
                              const std::atomic<bool>* interrupt = nullptr);

}  // namespace weft::meshing
