// Delaunay, recovery of edges and facets, removal of what is outside, Steiner points off the surface.
#include "meshing/initial/initial_grid.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <unordered_set>

#include "meshing/base/number_sets.h"
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

/// Connected pieces of the surface, numbered by facet: through edges, because where two meet in a vertex
/// alone one may be a void, or a body in a void, of what the other bounds.
std::vector<std::uint32_t> shells(const Recovery& r) {
  NumberSets sets(r.edges.size());
  for (const auto& edges : r.facet_edges)
    for (const std::uint32_t e : edges) sets.unite(e, edges[0]);
  std::vector<std::uint32_t> shell(r.facets.size());
  for (std::size_t i = 0; i < shell.size(); ++i) shell[i] = sets.of(r.facet_edges[i][0]);
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
  const std::vector<std::uint32_t> shell = shells(r);
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

double inscribed_radius(const TetGrid& grid, const Tet4& v) {
  const auto at = [&](int i) { return grid.points[v[static_cast<std::size_t>(i)]]; };
  double area = 0;
  for (const auto& f : kTetFaces) area += norm(cross(at(f[1]) - at(f[0]), at(f[2]) - at(f[0])));
  return area > 0 ? std::abs(six_volume(at(0), at(1), at(2), at(3))) / area : 0;
}

/// The middle of each region's tet with the largest inscribed sphere.
std::vector<Point> middles(const TetGrid& grid, std::span<const std::uint32_t> region, std::uint32_t count) {
  std::vector<double> largest(count, -1);
  std::vector<Point> at(count);
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    const Tet4& v = grid.tets[t].v;
    const double radius = inscribed_radius(grid, v);
    if (radius <= largest[region[t]]) continue;
    largest[region[t]] = radius;
    at[region[t]] = 0.25 * (grid.points[v[0]] + grid.points[v[1]] + grid.points[v[2]] + grid.points[v[3]]);
  }
  return at;
}

/// Which regions become part of the mesh. Each triangle bounds one of them at least, whatever bodies say.
std::vector<bool> wanted_regions(const TetGrid& grid, const Regions& regions, const GridOptions& options) {
  const auto count = static_cast<std::uint32_t>(regions.depth.size());
  std::vector<bool> wanted(count);
  std::vector<std::uint32_t> body;
  if (options.bodies_at) body = options.bodies_at(middles(grid, regions.of_tet, count));
  for (std::uint32_t r = 0; r < count; ++r)
    wanted[r] =
        regions.depth[r] > 0 &&
        (options.bodies_at ? body[r] != kNothing : options.keep_enclosed || regions.depth[r] % 2 == 1);
  if (!options.bodies_at) return wanted;
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t)
    for (std::size_t f = 0; f < 4 && grid.alive(t); ++f) {
      const std::uint32_t r = regions.of_tet[t], n = grid.tets[t].n[f];
      if (grid.tets[t].facet[f] != kNothing && !wanted[r] && !wanted[regions.of_tet[n >> 2]])
        wanted[r] = regions.depth[r] > 0;
    }
  return wanted;
}

/// Takes away what is outside and in voids; leaves no way to it. How many voids there were.
std::uint64_t carve(TetGrid& grid, const Regions& regions, const GridOptions& options) {
  const std::vector<bool> wanted = wanted_regions(grid, regions, options);
  std::fill(grid.vertex_tet.begin(), grid.vertex_tet.end(), kNothing);
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    if (wanted[regions.of_tet[t]]) {
      for (const std::uint32_t v : grid.tets[t].v) grid.vertex_tet[v] = t;
      continue;
    }
    for (const std::uint32_t n : grid.tets[t].n)
      if (n != kNothing) grid.tets[n >> 2].n[n & 3] = kNothing;
    grid.remove(t);
  }
  std::uint64_t voids = 0;
  for (std::size_t r = 0; r < wanted.size(); ++r) voids += !wanted[r] && regions.depth[r] > 0;
  return voids;
}

/// The grid as plain arrays.
class Export {
 public:
  Export(const Recovery& r, const ClosedSurface& surface, const GridOptions& options, InitialGrid& result)
      : r_(r), grid_(r.grid), surface_(surface), options_(options), result_(result) {}

  void run() {
    std::uint32_t count = 0;
    region_ = flood_regions(grid_, count);
    number_regions(count);
    add_points();
    add_tets();
    add_triangles();
    add_edges();
    copy_list(surface_.mesh.corners, new_index_, result_.mesh.corners);
    copy_list(surface_.mesh.required_points, new_index_, result_.mesh.required_points);
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
    if (options_.bodies_at) number_bodies(order);
  }

  /// What lies in no body, and is wanted all the same, comes after them.
  void number_bodies(const std::vector<std::uint32_t>& order) {
    const auto count = static_cast<std::uint32_t>(order.size());
    const std::vector<std::uint32_t> body = options_.bodies_at(middles(grid_, region_, count));
    std::int32_t last = 0;
    for (const std::uint32_t b : body)
      if (b != kNothing) last = std::max(last, static_cast<std::int32_t>(b + 1));
    for (const std::uint32_t r : order)
      ref_[r] = body[r] != kNothing ? static_cast<std::int32_t>(body[r] + 1) : ++last;
  }

  /// Points without tets go: added ones outside, and the surface's that have triangles between voids only.
  void add_points() {
    MeshData& m = result_.mesh;
    new_index_.assign(grid_.points.size(), kNothing);
    const std::size_t from_surface = surface_.mesh.points.size();
    for (std::uint32_t v = 0; v < grid_.points.size(); ++v) {
      if (grid_.vertex_tet[v] == kNothing) continue;
      new_index_[v] = static_cast<std::uint32_t>(m.points.size());
      m.points.push_back(grid_.points[v]);
      m.point_refs.push_back(v < from_surface ? surface_.mesh.point_refs[v] : 0);
      result_.steiner_points += v >= from_surface;
    }
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
    exported_.resize(r_.facets.size());
    std::vector<bool> required(r_.facets.size());
    for (const std::uint32_t facet : surface_.mesh.required_triangles) required[facet] = true;
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) {
      if (!grid_.alive(t)) continue;
      for (std::uint32_t f = 0; f < 4; ++f) {
        const std::uint32_t facet = grid_.tets[t].facet[f], n = grid_.tets[t].n[f];
        if (facet == kNothing || (n != kNothing && !first_side(t, n >> 2))) continue;
        const Face3 w = grid_.face(t, static_cast<int>(f));
        const Face3 out = {w[0], w[2], w[1]};
        result_.turned += n == kNothing && turns_against(out, facet);
        if (required[facet]) m.required_triangles.push_back(static_cast<std::uint32_t>(m.triangles.size()));
        m.triangles.push_back({new_index_[out[0]], new_index_[out[1]], new_index_[out[2]]});
        m.triangle_refs.push_back(surface_.mesh.triangle_refs[facet]);
        exported_[facet] = true;
      }
    }
  }

  /// Listed edges of the triangles that are part of the mesh: those between two voids are not.
  void add_edges() {
    const MeshData& from = surface_.mesh;
    std::unordered_set<std::uint64_t> there;
    for (std::size_t i = 0; i < exported_.size() && !from.edges.empty(); ++i)
      for (std::size_t k = 0; k < 3 && exported_[i]; ++k)
        there.insert(Recovery::key(r_.facets[i][k], r_.facets[i][(k + 1) % 3]));
    MeshData& m = result_.mesh;
    std::vector<std::uint32_t> number(from.edges.size(), kNothing);
    for (std::size_t i = 0; i < from.edges.size(); ++i) {
      const auto& [a, b] = from.edges[i];
      if (!there.contains(Recovery::key(a, b))) continue;
      number[i] = static_cast<std::uint32_t>(m.edges.size());
      m.edges.push_back({new_index_[a], new_index_[b]});
      m.edge_refs.push_back(from.edge_refs[i]);
    }
    copy_list(from.ridges, number, m.ridges);
    copy_list(from.required_edges, number, m.required_edges);
  }

  /// Of what is listed, that which is still there, by its new numbers.
  static void copy_list(const std::vector<std::uint32_t>& list, const std::vector<std::uint32_t>& now,
                        std::vector<std::uint32_t>& to) {
    for (const std::uint32_t i : list)
      if (now[i] != kNothing) to.push_back(now[i]);
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
  const GridOptions& options_;
  InitialGrid& result_;
  std::vector<std::uint32_t> region_, new_index_;
  std::vector<std::int32_t> ref_;
  std::vector<bool> exported_;  ///< of each facet: whether a triangle of the mesh is a piece of it
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
  r.source = surface.source;
  remove_slivers(r);
  list_input_edges(r);
  recover_edges(r);
  recover_facets(r);
  const auto outside = static_cast<std::uint32_t>(surface.mesh.points.size());
  InitialGrid result;
  result.voids = carve(r.grid, find_regions(r, outside), options);
  free_surface(r, result);
  Export(r, surface, options, result).run();
  return result;
}

}  // namespace weft::meshing
