// Deviation of boundary triangles from the reference surface.
#include "meshing/surface_fit.h"

namespace weft::meshing {
namespace {

Vec triangle_normal(const TetMesh& mesh, const std::array<VertexId, 3>& t) {
  return cross(mesh.point(t[1]) - mesh.point(t[0]), mesh.point(t[2]) - mesh.point(t[0]));
}

}  // namespace

double surface_distance(const Kernel& k, PatchId patch, const Point& p, VertexId near) {
  const auto q = k.surface.project_to_patch(patch, p, k.mesh.kind(near), k.mesh.surface_hint(near));
  return norm(p - q.x);
}

double bulge(const Kernel& k, VertexId a, VertexId b, PatchId patch) {
  const TetMesh& mesh = k.mesh;
  const Point middle = midpoint(mesh.point(a), mesh.point(b));
  CurveId curve;
  if (mesh.kind(a) >= VertexKind::ridge && mesh.kind(b) >= VertexKind::ridge) curve = mesh.curve(a, b);
  Vec way;
  if (curve.valid()) {
    if (k.surface.curves()[curve.value].straight) return 0;
    way = k.surface.project_to_curve(curve, middle, mesh.kind(a), mesh.surface_hint(a)).x - middle;
  } else {
    way = k.surface.project_to_patch(patch, middle, mesh.kind(a), mesh.surface_hint(a)).x - middle;
  }
  return edge_length_fast(way, mesh.metric(a), mesh.metric(b));
}

bool fits_surface(const Kernel& k, PatchId patch, const std::array<VertexId, 3>& changed, const std::array<VertexId, 3>& old) {
  const TetMesh& mesh = k.mesh;
  const Vec n = triangle_normal(mesh, changed), o = triangle_normal(mesh, old);
  if (dot(n, o) < 0.5 * norm(n) * norm(o)) return false;
  const Point &a = mesh.point(changed[0]), &b = mesh.point(changed[1]), &c = mesh.point(changed[2]);
  const Point centroid = (1.0 / 3) * (a + b + c);
  const auto q = k.surface.project_to_patch(patch, centroid, mesh.kind(changed[0]), mesh.surface_hint(changed[0]));
  // Folding shows against the surface's own normal as well: `old` may have been bent already.
  const double side = dot(o, q.normal) < 0 ? -1 : 1;
  if (side * dot(n, q.normal) < 0.5 * norm(n) || norm(centroid - q.x) > k.limits.hausd) return false;
  for (int i = 0; i < 3; ++i) {
    const VertexId u = changed[i], v = changed[(i + 1) % 3];
    if (surface_distance(k, patch, midpoint(mesh.point(u), mesh.point(v)), u) > k.limits.hausd) return false;
  }
  return true;
}

}  // namespace weft::meshing
