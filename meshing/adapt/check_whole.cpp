// The kernel's mesh as plain arrays for check_mesh.
#include "meshing/adapt/check_whole.h"

#include <string>

#include "meshing/mesh/check_mesh.h"

namespace weft::meshing {
namespace {

/// Live tets, and a triangle for each face on a patch or without neighbour: a subdomain's mesh ends at faces
/// of frozen vertices.
MeshData live_part(const TetMesh& mesh) {
  MeshData data;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) data.points.push_back(mesh.point(VertexId(i)));
  data.point_refs.assign(data.points.size(), 0);
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    const TetVertices v = mesh.vertices(t);
    data.tets.push_back({v[0].value, v[1].value, v[2].value, v[3].value});
    data.tet_refs.push_back(mesh.ref(t));
    for (int f = 0; f < 4; ++f) {
      const TetFace n = mesh.neighbour(t, f);
      if (n.valid() && (!mesh.patch(t, f).valid() || n.tet() < t)) continue;
      const auto& face = kTetFaces[f];
      data.triangles.push_back({v[face[0]].value, v[face[2]].value, v[face[1]].value});
      data.triangle_refs.push_back(0);
    }
  }
  return data;
}

bool links_hold(const TetMesh& mesh, TetId t) {
  for (int i = 0; i < 4; ++i) {
    const TetFace across = mesh.neighbour(t, i);
    if (across.valid() &&
        (!mesh.alive(across.tet()) || mesh.neighbour(across.tet(), across.face()).code != TetFace(t, i).code))
      return false;
    if (!mesh.alive(mesh.vertex(t, i))) return false;
  }
  return true;
}

bool links_hold(const TetMesh& mesh, VertexId v) {
  const TetId t = mesh.tet_of(v);
  return mesh.alive(t) && mesh.local_index(t, v) >= 0;
}

}  // namespace

bool links_hold(const TetMesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (mesh.alive(TetId(i)) && !links_hold(mesh, TetId(i))) return false;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i)) && !links_hold(mesh, VertexId(i))) return false;
  return true;
}

void check_live_mesh(const TetMesh& mesh, const char* when) {
  const CheckReport report = check_mesh(live_part(mesh), 1);
  if (!report.ok())
    fail_assertion("the mesh conforms", when + (": " + report.problems[0]), __FILE__, __LINE__);
}

}  // namespace weft::meshing
