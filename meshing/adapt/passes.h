// The passes of an adaptation: one operation over everything that is marked for it.
#pragma once

#include <cstdint>

#include "meshing/adapt/worklist.h"

namespace weft::meshing {

/// Moves boundary vertices onto the CAD model; returns how many could not be.
std::uint64_t snap_pass(WorkerPool& pool);
/// Splits the longest edge of every marked tet that has one longer than limits.long_edge; boundary edges that
/// curve too much first.
std::uint64_t split_pass(WorkerPool& pool);
/// Splits only boundary edges that curve too much, and leaves the marks for split_pass.
std::uint64_t resolve_curved_pass(WorkerPool& pool);
/// Collapses marked vertices into their nearest neighbour nearer than limits.short_edge that allows it.
std::uint64_t collapse_pass(WorkerPool& pool);
/// Swaps edges and faces of marked tets with a mean ratio below `quality`; of those with a frozen vertex only
/// below `quality_at_frozen`.
std::uint64_t swap_pass(WorkerPool& pool, double quality, double quality_at_frozen = 1);
/// Smooths marked vertices.
std::uint64_t smooth_pass(WorkerPool& pool);
/// Both, vertex by vertex: what both look at is gathered once.
std::uint64_t smooth_and_collapse_pass(WorkerPool& pool);
/// Smooths the vertices of tets with a mean ratio below `quality` that have changed.
std::uint64_t smooth_poor(WorkerPool& pool, double quality);
/// Repairs marked tets with a mean ratio below `quality` by whatever helps: swap, relocation, collapse,
/// split.
std::uint64_t improve_pass(WorkerPool& pool, double quality);

}  // namespace weft::meshing
