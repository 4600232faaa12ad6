// Delaunay, recovery of edges and facets, removal of what is outside, Steiner points off the surface.
#include "meshing/initial/initial_grid.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "meshing/initial/grid/delaunay.h"
#include "meshing/initial/recovery/improve_tets.h"
#include "meshing/initial/recovery/lift_steiner.h"
#include "meshing/initial/recovery/recover_edges.h"
#include "meshing/initial/recovery/recover_facets.h"
#include "meshing/initial/recovery/recovery.h"
#include "meshing/initial/recovery/remove_slivers.h"

namespace weft::meshing {
namespace {

/// Volumes between the facets, and how deep each is: 0 outside, one more for every shell around it.
struct Regions {
  std::vector<std::uint32_t> of_tet;
  std::vector<int> depth;
};

/// Connected pieces of the surface (through vertices), numbered by facet.
std::vector<std::uint32_t> shells(const std::vector<Face3>& facets, std::size_t num_points) {
  std::vector<std::uint32_t> parent(num_points);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Face3& f : facets)
    for (const std::uint32_t v : f) parent[root(v)] = root(f[0]);
  std::vector<std::uint32_t> shell(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) shell[i] = root(facets[i][0]);
  return shell;
}

/// From the outside inwards: whatever lies behind a shell is one deeper than the region from which the shell
/// is seen first, and volumes that one shell divides are equally deep.
Regions find_regions(const Recovery& r, std::uint32_t outside_vertex) {
  const TetGrid& grid = r.grid;
  Regions regions;
  std::uint32_t count = 0;
  regions.of_tet = flood_regions(grid, count);
  regions.depth.assign(count, -1);
  std::map<std::uint32_t, std::vector<std::uint32_t>> of_shell;   // shell -> regions at it
  std::map<std::uint32_t, std::vector<std::uint32_t>> at_region;  // region -> shells at it
  const std::vector<std::uint32_t> shell = shells(r.facets, grid.points.size());
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    for (const std::uint32_t facet : grid.tets[t].facet) {
      if (facet == kNothing) continue;
      auto& there = of_shell[shell[facet]];
      if (std::find(there.begin(), there.end(), regions.of_tet[t]) != there.end()) continue;
      there.push_back(regions.of_tet[t]);
      at_region[regions.of_tet[t]].push_back(shell[facet]);
    }
  }
  std::vector<std::uint32_t> queue = {regions.of_tet[grid.vertex_tet[outside_vertex]]};
  regions.depth[queue[0]] = 0;
  for (std::size_t i = 0; i < queue.size(); ++i)
    for (const std::uint32_t s : at_region[queue[i]])
      for (const std::uint32_t next : of_shell[s]) {
        if (regions.depth[next] >= 0) continue;
        regions.depth[next] = regions.depth[queue[i]] + 1;
        queue.push_back(next);
      }
  return regions;
}

/// Takes away what is outside and in holes; leaves no way to it.
void carve(TetGrid& grid, const Regions& regions, const GridOptions& options) {
  const auto inside = [&](std::uint32_t t) {
    const int depth = regions.depth[regions.of_tet[t]];
    return depth > 0 && (options.keep_enclosed || depth % 2 == 1);
  };
  std::fill(grid.vertex_tet.begin(), grid.vertex_tet.end(), kNothing);
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    if (inside(t)) {
      for (const std::uint32_t v : grid.tets[t].v) grid.vertex_tet[v] = t;
      continue;
    }
    for (const std::uint32_t n : grid.tets[t].n)
      if (n != kNothing) grid.tets[n >> 2].n[n & 3] = kNothing;
    grid.remove(t);
  }
}

/// The grid as plain arrays.
class Export {
 public:
  Export(const Recovery& r, const ClosedSurface& surface, InitialGrid& result)
      : r_(r), grid_(r.grid), surface_(surface), result_(result) {}

  void run() {
    std::uint32_t count = 0;
    region_ = flood_regions(grid_, count);
    number_regions(count);
    add_points();
    add_tets();
    add_triangles();
    MeshData& m = result_.mesh;
    m.edges = surface_.mesh.edges;
    m.edge_refs = surface_.mesh.edge_refs;
    m.ridges = surface_.mesh.ridges;
    m.corners = surface_.mesh.corners;
  }

 private:
  void number_regions(std::uint32_t count) {
    std::vector<std::uint32_t> first(count, kNothing), order(count);
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t)
      if (grid_.alive(t))
        for (const std::uint32_t facet : grid_.tets[t].facet)
          first[region_[t]] = std::min(first[region_[t]], facet);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return first[a] < first[b]; });
    ref_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) ref_[order[i]] = static_cast<std::int32_t>(i + 1);
    result_.regions = count;
  }

  /// All the surface's points have tets, because all its triangles bound a volume or divide one, unless they
  /// lie in a hole: such points go.
  void add_points() {
    MeshData& m = result_.mesh;
    new_index_.assign(grid_.points.size(), kNothing);
    const std::size_t from_surface = surface_.mesh.points.size();
    for (std::uint32_t v = 0; v < grid_.points.size(); ++v) {
      if (v >= from_surface && grid_.vertex_tet[v] == kNothing) continue;
      new_index_[v] = static_cast<std::uint32_t>(m.points.size());
      m.points.push_back(grid_.points[v]);
      m.point_refs.push_back(v < from_surface ? surface_.mesh.point_refs[v] : 0);
    }
    result_.steiner_points = m.points.size() - from_surface;
  }

  void add_tets() {
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) {
      if (!grid_.alive(t)) continue;
      Tet4 v = grid_.tets[t].v;
      for (std::uint32_t& w : v) w = new_index_[w];
      result_.mesh.tets.push_back(v);
      result_.mesh.tet_refs.push_back(ref_[region_[t]]);
    }
  }

  /// Every face that is a piece of a facet once: seen from the tet of smaller reference, from outside.
  void add_triangles() {
    MeshData& m = result_.mesh;
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) {
      if (!grid_.alive(t)) continue;
      for (std::uint32_t f = 0; f < 4; ++f) {
        const std::uint32_t facet = grid_.tets[t].facet[f], n = grid_.tets[t].n[f];
        if (facet == kNothing || (n != kNothing && !first_side(t, n >> 2))) continue;
        const Face3 w = grid_.face(t, static_cast<int>(f));
        const Face3 out = {w[0], w[2], w[1]};
        result_.turned += n == kNothing && turns_against(out, facet);
        m.triangles.push_back({new_index_[out[0]], new_index_[out[1]], new_index_[out[2]]});
        m.triangle_refs.push_back(surface_.mesh.triangle_refs[facet]);
      }
    }
  }

  bool first_side(std::uint32_t t, std::uint32_t n) const {
    return std::pair(ref_[region_[t]], t) < std::pair(ref_[region_[n]], n);
  }

  bool turns_against(const Face3& w, std::uint32_t facet) const {
    const auto normal = [&](const Face3& f) {
      return cross(grid_.points[f[1]] - grid_.points[f[0]], grid_.points[f[2]] - grid_.points[f[0]]);
    };
    return dot(normal(w), normal(r_.facets[facet])) < 0;
  }

  const Recovery& r_;
  const TetGrid& grid_;
  const ClosedSurface& surface_;
  InitialGrid& result_;
  std::vector<std::uint32_t> region_, new_index_;
  std::vector<std::int32_t> ref_;
};

/// Steiner points that found no way off the surface may find one when the tets beside them are better.
void free_surface(Recovery& r, InitialGrid& result) {
  constexpr int kMostRounds = 3;
  for (int round = 0; round < kMostRounds; ++round) {
    result.left_on_surface = lift_steiner_points(r);
    if (result.left_on_surface == 0) return;
    improve_tets(r.grid);
  }
  round_steiner_points(r);
}

}  // namespace

InitialGrid make_initial_grid(const ClosedSurface& surface, const GridOptions& options) {
  Recovery r;
  r.grid = delaunay_in_box(surface.mesh.points, options.interrupt);
  r.facets = surface.mesh.triangles;
  remove_slivers(r);
  list_input_edges(r);
  recover_edges(r);
  recover_facets(r);
  const auto outside = static_cast<std::uint32_t>(surface.mesh.points.size());
  carve(r.grid, find_regions(r, outside), options);
  InitialGrid result;
  free_surface(r, result);
  Export(r, surface, result).run();
  return result;
}

}  // namespace weft::meshing
