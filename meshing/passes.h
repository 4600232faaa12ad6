// The passes of an adaptation: one operation over everything that is marked for it.
#pragma once

#include <cstdint>

#include "meshing/sweep.h"

namespace weft::meshing {

/// Splits the longest edge of every marked tet that has one longer than `longest`.
std::uint64_t split_pass(Crew& crew, double longest);
/// Collapses edges shorter than limits.short_edge of marked tets, shortest first.
std::uint64_t collapse_pass(Crew& crew);
/// Swaps edges and faces of marked tets with a mean ratio below `quality`.
std::uint64_t swap_pass(Crew& crew, double quality);
/// Smooths marked vertices.
std::uint64_t smooth_pass(Crew& crew);
/// Repairs marked tets with a mean ratio below `quality` by whatever helps: swap, collapse, relocation, split.
std::uint64_t improve_pass(Crew& crew, double quality);

}  // namespace weft::meshing
