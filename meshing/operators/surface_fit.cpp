// Deviation of boundary triangles from the reference surface.
#include "meshing/operators/surface_fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "meshing/base/sort_unique.h"

namespace weft::meshing {
namespace {

// Of an edge's length: the arc above it turns by 30 degrees. Tets upon longer arcs are in the way of what is
// to come, however far the boundary may bulge at a level.
constexpr double kMostBulge = 0.0658;

Vec triangle_normal(const TetMesh& mesh, const std::array<VertexId, 3>& t) {
  return cross(mesh.point(t[1]) - mesh.point(t[0]), mesh.point(t[2]) - mesh.point(t[0]));
}

bool is_edge_of(const std::array<VertexId, 3>& t, VertexId a, VertexId b) {
  return std::find(t.begin(), t.end(), a) != t.end() && std::find(t.begin(), t.end(), b) != t.end();
}

/// The way from the middle of a boundary edge to the geometry.
Vec bulge(const Kernel& k, VertexId a, VertexId b, PatchId patch) {
  const TetMesh& mesh = k.mesh;
  const Point middle = midpoint(mesh.point(a), mesh.point(b));
  const CurveId curve = mesh.curve(a, b);
  if (!curve.valid())
    return k.surface.project_to_patch(patch, middle, mesh.kind(a), mesh.surface_hint(a)).x - middle;
  if (k.surface.curves()[curve.value].straight) return {};
  return k.surface.project_to_curve(curve, middle, mesh.kind(a), mesh.surface_hint(a)).x - middle;
}

/// An edge of a boundary triangle.
struct BoundaryEdge {
  VertexId a, b;
  PatchId patch;
  friend auto operator<=>(const BoundaryEdge&, const BoundaryEdge&) = default;
};

/// Calls visit(tet, face, patch) for the faces on curved patches.
template <class Visit>
void for_curved_faces(const TetMesh& mesh, const Surface& surface, Visit visit) {
  const auto patches = surface.patches();
  if (std::ranges::all_of(patches, &Patch::planar)) return;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    for (int f = 0; f < 4 && mesh.alive(TetId(i)); ++f)
      if (const PatchId patch = mesh.patch(TetId(i), f); patch.valid() && !patches[patch.value].planar)
        visit(TetId(i), f, patch);
}

/// Those on curved patches, once for each patch.
std::vector<BoundaryEdge> curved_edges(const Kernel& k) {
  std::vector<BoundaryEdge> edges;
  for_curved_faces(k.mesh, k.surface, [&](TetId t, int f, PatchId patch) {
    for (int j = 0; j < 3; ++j) {
      const VertexId a = k.mesh.vertex(t, kTetFaces[f][j]), b = k.mesh.vertex(t, kTetFaces[f][(j + 1) % 3]);
      edges.push_back({std::min(a, b), std::max(a, b), patch});
    }
  });
  sort_unique(edges);
  return edges;
}

}  // namespace

double surface_deviation(const TetMesh& mesh, const Surface& surface, PatchId patch, TetId t, int face) {
  Point centroid;
  for (const int i : kTetFaces[face]) centroid += (1.0 / 3) * mesh.point(mesh.vertex(t, i));
  const VertexId near = mesh.vertex(t, kTetFaces[face][0]);
  return norm(centroid -
              surface.project_to_patch(patch, centroid, mesh.kind(near), mesh.surface_hint(near)).x);
}

double largest_surface_deviation(const TetMesh& mesh, const Surface& surface) {
  double largest = 0;
  for_curved_faces(mesh, surface, [&](TetId t, int f, PatchId patch) {
    largest = std::max(largest, surface_deviation(mesh, surface, patch, t, f));
  });
  return largest;
}

std::vector<SurfaceDemand> surface_demands(const Kernel& k) {
  std::map<std::int32_t, SurfaceDemand> of_ref;
  for (const auto& [a, b, patch] : curved_edges(k)) {
    const double length = length_between(k.mesh, a, b);
    if (length >= k.limits.short_edge) continue;
    // The deviation grows with the square of the length.
    const double allowed = length * std::sqrt(k.hausd(patch) / norm(bulge(k, a, b, patch)));
    if (!(allowed < 1)) continue;
    const std::int32_t ref = k.surface.patches()[patch.value].ref;
    SurfaceDemand& demand = of_ref.try_emplace(ref, SurfaceDemand{ref, 0, allowed, {}}).first->second;
    if (demand.edges++ == 0 || allowed < demand.allowed) {
      demand.allowed = allowed;
      demand.where = midpoint(k.mesh.point(a), k.mesh.point(b));
    }
  }
  std::vector<SurfaceDemand> demands;
  for (const auto& [ref, demand] : of_ref) demands.push_back(demand);
  std::ranges::stable_sort(demands, std::greater{}, &SurfaceDemand::edges);
  return demands;
}

bool curves_too_much(const Kernel& k, VertexId a, VertexId b, PatchId patch) {
  const Vec way = bulge(k, a, b, patch);
  const Limits& limits = k.limits;
  if (norm(way) > k.hausd(patch)) return true;
  return (norm(way) > kMostBulge * norm(k.mesh.point(b) - k.mesh.point(a)) ||
          edge_length_fast(way, k.mesh.metric(a), k.mesh.metric(b)) > limits.largest_bulge) &&
         length_between(k.mesh, a, b) > limits.finest_long_edge;
}

double edge_deviation(const Kernel& k, VertexId a, VertexId b, PatchId patch) {
  return norm(bulge(k, a, b, patch));
}

bool fits_surface(const Kernel& k, PatchId patch, const std::array<VertexId, 3>& changed,
                  const std::array<VertexId, 3>& old, double before) {
  const TetMesh& mesh = k.mesh;
  const Vec n = triangle_normal(mesh, changed), o = triangle_normal(mesh, old);
  const Point centroid =
      (1.0 / 3) * (mesh.point(changed[0]) + mesh.point(changed[1]) + mesh.point(changed[2]));
  const auto q =
      k.surface.project_to_patch(patch, centroid, mesh.kind(changed[0]), mesh.surface_hint(changed[0]));
  // Folding shows against the surface's own normal as well: `old` may have been bent already.
  const double side = dot(o, q.normal) < 0 ? -1 : 1;
  // Against that of one that stands on the surface nothing can be said: what mends it turns the normal.
  const bool was_bent = side * dot(o, q.normal) < 0.5 * norm(o);
  if (!was_bent && dot(n, o) < 0.5 * norm(n) * norm(o)) return false;
  if (side * dot(n, q.normal) < 0.5 * norm(n)) return false;
  if (norm(centroid - q.x) > std::max(k.hausd(patch), before)) return false;
  for (int i = 0; i < 3; ++i) {
    const VertexId a = changed[i], b = changed[(i + 1) % 3];
    if (is_edge_of(old, a, b) || !curves_too_much(k, a, b, patch)) continue;
    if (before == 0 || edge_deviation(k, a, b, patch) > before) return false;
  }
  return true;
}

}  // namespace weft::meshing
