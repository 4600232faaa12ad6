// Coarse to fine: each pass's mesh carries the sizes of the next, because a grid without inner points cannot.
#include "meshing/initial/fill_volume.h"

#include <limits>
#include <numeric>

#include "meshing/initial/grid/grid_of_mesh.h"
#include "meshing/initial/inner_points.h"
#include "meshing/initial/point_distribution.h"
#include "meshing/initial/recovery/improve_tets.h"
#include "meshing/io/files/point_merger.h"

namespace weft::meshing {
namespace {

/// The grid with a surface that adapt() leaves alone.
MeshData with_fixed_surface(const MeshData& grid) {
  MeshData mesh = grid;
  mesh.required_triangles.resize(mesh.triangles.size());
  std::iota(mesh.required_triangles.begin(), mesh.required_triangles.end(), 0u);
  return mesh;
}

/// Replaces what adapt() lists (every edge of a required triangle) by what the grid listed; points that have
/// not moved are known by their coordinates.
void restore_lists(const MeshData& grid, MeshData& mesh) {
  std::vector<Point> points;
  PointMerger merger(points);
  merger.reserve(mesh.points.size());
  for (const Point& p : mesh.points) merger.index(p);
  mesh.required_triangles.clear();
  mesh.required_edges.clear();
  mesh.required_points.clear();
  mesh.corners.clear();
  mesh.edges.clear();
  mesh.edge_refs = grid.edge_refs;
  mesh.ridges = grid.ridges;
  for (const auto& [a, b] : grid.edges)
    mesh.edges.push_back({merger.index(grid.points[a]), merger.index(grid.points[b])});
  for (const std::uint32_t v : grid.corners) mesh.corners.push_back(merger.index(grid.points[v]));
}

/// What the kernel is given: its worst tets have been made better, and where the surface is kept there are
/// points inside, which carry the sizes, so that adapt() has little more to do than to move them.
MeshData prepared(const MeshData& start, const FillOptions& options) {
  GridOfMesh filled(start);
  if (!options.remesh_surface && !options.background.mesh) {
    const double largest = options.size > 0 ? options.size : std::numeric_limits<double>::infinity();
    const std::vector<SizeSource> sources =
        PointDistribution(start, options.growth, options.size).size_sources();
    insert_inner_points(filled.grid, sources, spread_sizes(start, sources), largest, options.adapt.threads,
                        options.adapt.interrupt);
  }
  improve_tets(filled.grid);
  return filled.take();
}

AdaptResult fill_kept_surface(const MeshData& input, const FillOptions& options) {
  const LogMetricField metric =
      PointDistribution(input, options.growth, options.size).sample_inside(input, 1);
  AdaptOptions adapt_options = options.adapt;
  adapt_options.coarsen = false;  // the points are where they should be, however poor the tets are
  return adapt(input, {&input, &metric}, adapt_options);
}

/// A surface that is adapted has lost its own sizes after the coarse pass, which makes points to carry them.
AdaptResult fill_and_remesh(const MeshData& start, const FillOptions& options) {
  const PointDistribution of_start(start, options.growth, options.size);
  AdaptResult result;
  result.mesh = start;
  for (const double factor : {4.0, 1.0}) {
    const MeshData input = std::move(result.mesh);
    const LogMetricField metric = of_start.sample(input.points, factor);
    result = adapt(input, {&input, &metric}, options.adapt);
    if (result.report.interrupted) break;
  }
  return result;
}

}  // namespace

AdaptResult fill_volume(const MeshData& grid, const FillOptions& options) {
  const MeshData start = prepared(options.remesh_surface ? grid : with_fixed_surface(grid), options);
  AdaptResult result = options.background.mesh  ? adapt(start, options.background, options.adapt)
                       : options.remesh_surface ? fill_and_remesh(start, options)
                                                : fill_kept_surface(start, options);
  if (!options.remesh_surface) restore_lists(grid, result.mesh);
  return result;
}

}  // namespace weft::meshing
