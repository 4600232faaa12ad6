// Coarse to fine: each pass's mesh carries the sizes of the next, because a grid without inner points cannot.
#include "meshing/initial/fill_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "meshing/initial/grid/grid_of_mesh.h"
#include "meshing/initial/inner_points.h"
#include "meshing/initial/point_distribution.h"
#include "meshing/initial/recovery/improve_tets.h"
#include "meshing/io/files/point_merger.h"
#include "meshing/metric/measures.h"

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
  const auto now = [&](std::uint32_t v) { return merger.index(grid.points[v]); };
  mesh.edges.clear();
  for (const auto& [a, b] : grid.edges) mesh.edges.push_back({now(a), now(b)});
  mesh.edge_refs = grid.edge_refs;
  mesh.ridges = grid.ridges;
  mesh.required_edges = grid.required_edges;
  mesh.corners.resize(grid.corners.size());
  std::ranges::transform(grid.corners, mesh.corners.begin(), now);
  mesh.required_points.resize(grid.required_points.size());
  std::ranges::transform(grid.required_points, mesh.required_points.begin(), now);
  std::set<Triangle> required;
  for (const std::uint32_t t : grid.required_triangles) {
    const auto& [a, b, c] = grid.triangles[t];
    required.insert(face_key({now(a), now(b), now(c)}));
  }
  mesh.required_triangles.clear();
  for (std::uint32_t t = 0; t < mesh.triangles.size() && !required.empty(); ++t)
    if (required.contains(face_key(mesh.triangles[t]))) mesh.required_triangles.push_back(t);
}

/// Its worst tets have been made better.
MeshData improved(const MeshData& start) {
  GridOfMesh grid(start);
  improve_tets(grid.grid);
  return grid.take();
}

/// Points behind those that have sizes get theirs from their neighbours.
void spread_to_new_points(const TetGrid& grid, std::span<const SizeSource> sources,
                          std::vector<SpreadSize>& sizes) {
  const std::size_t first = sizes.size();
  sizes.resize(grid.points.size(), {std::numeric_limits<double>::infinity(), 0, 0});
  std::vector<Tet4> at_new;
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t)
    if (grid.alive(t) && std::ranges::max(grid.tets[t].v) >= first) at_new.push_back(grid.tets[t].v);
  const auto reach = [&](std::uint32_t to, std::uint32_t from) {
    if (to < first || !std::isfinite(sizes[from].size)) return false;
    const SizeSource& source = sources[sizes[from].source];
    const SpreadSize size = spread_on(sizes[from], source, grid.points[source.vertex],
                                      norm(grid.points[to] - grid.points[from]), grid.points[to]);
    if (size.size >= sizes[to].size) return false;
    sizes[to] = size;
    return true;
  };
  for (bool changed = true; std::exchange(changed, false);)
    for (const Tet4& tet : at_new)
      for (const std::uint32_t to : tet)
        for (const std::uint32_t from : tet) changed |= reach(to, from);
}

/// Points inside carry the sizes, so that adapt() has little more to do than to move them.
AdaptResult fill_kept_surface(const MeshData& start, const FillOptions& options) {
  const double largest = options.size > 0 ? options.size : std::numeric_limits<double>::infinity();
  const std::vector<SizeSource> sources =
      PointDistribution(start, options.growth, options.size).size_sources();
  GridOfMesh filled(start);
  std::vector<SpreadSize> sizes =
      insert_inner_points(filled.grid, sources, spread_sizes(start, sources), largest, options.adapt.threads,
                          options.adapt.interrupt);
  improve_tets(filled.grid);
  spread_to_new_points(filled.grid, sources, sizes);
  LogMetricField metric;
  for (const std::uint32_t v : filled.points_of_tets())
    metric.push_back(identity_tensor(-2 * std::log(std::min(sizes[v].size, largest))));
  const MeshData input = filled.take();
  AdaptOptions adapt_options = options.adapt;
  adapt_options.coarsen = false;  // the points are where they should be, however poor the tets are
  return adapt(input, {&input, &metric}, adapt_options);
}

/// How the result lies on the model is to be seen beside the surface that was given.
void compare_with(const ModelFaults& of_surface, AdaptReport& report) {
  if (!report.model) return;
  ModelAccount account = *report.model;
  account.input = of_surface;
  report.model = std::make_shared<const ModelAccount>(std::move(account));
}

/// By how much the sizes of the next pass are too large; `last`: of the pass before, `mesh`: which came of
/// it. Along long edges between small sizes, as a grid without inner points has them, an adaptation makes
/// points that are not asked for. Where these would be millions, passes are so coarse at first that they are
/// few; fine parts of a flat surface may be lost in these.
double next_factor(double last, const PointDistribution& sizes, const MeshData& mesh) {
  constexpr double kBeforeLast = 4, kMany = 1e6, kFew = 2e4, kGrowth = 4;
  if (last <= kBeforeLast) return 1;
  const double made = complexity(mesh, sizes.sample(mesh.points, 1));
  const auto points = static_cast<double>(mesh.points.size());
  if (made <= std::pow(kBeforeLast, 3) * std::max(kMany, kGrowth * points)) return kBeforeLast;
  return std::max(kBeforeLast, std::min(std::cbrt(made / std::max(kFew, kGrowth * points)), last / 2));
}

/// A surface that is adapted has lost its own sizes after a coarse pass, which makes points to carry them.
AdaptResult fill_and_remesh(const MeshData& start, const FillOptions& options) {
  const PointDistribution of_start(start, options.growth, options.size);
  AdaptResult result;
  result.mesh = start;
  std::optional<ModelFaults> of_surface;
  for (double factor = std::numeric_limits<double>::infinity(); factor > 1;) {
    const MeshData input = std::move(result.mesh);
    factor = next_factor(factor, of_start, input);
    const LogMetricField metric = of_start.sample(input.points, factor);
    result = adapt(input, {&input, &metric}, options.adapt);
    if (!of_surface && result.report.model) of_surface = result.report.model->input;
    if (of_surface) compare_with(*of_surface, result.report);
    if (result.report.interrupted) break;
  }
  return result;
}

}  // namespace

AdaptResult fill_volume(const MeshData& grid, const FillOptions& options) {
  if (options.remesh_surface) {
    const MeshData start = improved(grid);
    return options.background.mesh ? adapt(start, options.background, options.adapt)
                                   : fill_and_remesh(start, options);
  }
  const MeshData start = with_fixed_surface(grid);
  AdaptResult result = options.background.mesh ? adapt(improved(start), options.background, options.adapt)
                                               : fill_kept_surface(start, options);
  restore_lists(grid, result.mesh);
  return result;
}

}  // namespace weft::meshing
