// From a closed surface to tets that have its triangles as faces.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "meshing/initial/closed_surface.h"

namespace weft::meshing {

struct GridOptions {
  bool keep_enclosed = false;  ///< a shell inside a volume bounds a material of its own; else a hole
  /// In which body each point lies, kNothing: in none. Where given, it tells materials from voids.
  std::function<std::vector<std::uint32_t>(std::span<const Point>)> bodies_at = {};
  const std::atomic<bool>* interrupt = nullptr;
};

struct InitialGrid {
  /// The surface's points first, in its order, then those added inside. Triangles are the surface's, turned
  /// outwards (from the tets of smaller reference at a material interface). What of the surface lies between
  /// two voids is left out. Tet references are the numbers of
  /// bodies, where GridOptions::bodies_at is given, else of volumes in the order of the first triangle on
  /// them; both from 1.
  MeshData mesh;
  std::uint64_t steiner_points = 0;   ///< added inside, to make room for the surface's triangles
  std::uint64_t left_on_surface = 0;  ///< added on the surface, and impossible to move off it
  std::uint64_t regions = 0;
  std::uint64_t voids = 0;   ///< enclosed volumes that are no part of the mesh
  std::uint64_t turned = 0;  ///< triangles of the surface that looked inwards
};

/// A tetrahedrisation of the volumes that the surface bounds, without regard to quality. Throws InputError
/// naming the triangle (of the input, 1-based) that cannot be made part of it, and Interrupted once
/// GridOptions::interrupt is set.
InitialGrid make_initial_grid(const ClosedSurface& surface, const GridOptions& options);

}  // namespace weft::meshing
