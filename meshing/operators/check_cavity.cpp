// The invariants of a ball.
#include "meshing/operators/check_cavity.h"

#include <string>

#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

void require(bool holds, const char* what, TetId t) {
  if (!holds)
    fail_assertion(what, "tet " + std::to_string(t.value) + " after an operator", __FILE__, __LINE__);
}

void check_face(const TetMesh& mesh, TetId t, int f) {
  const TetFace n = mesh.neighbour(t, f);
  if (!n.valid())
    return require(mesh.patch(t, f).valid() || mesh.frozen(mesh.vertex(t, kTetFaces[f][0])),
                   "a face without neighbour is on a patch or frozen", t);
  require(mesh.alive(n.tet()), "neighbours are alive", t);
  require(mesh.neighbour(n.tet(), n.face()) == TetFace(t, f), "neighbours are mutual", t);
  require(mesh.patch(n.tet(), n.face()) == mesh.patch(t, f), "neighbours agree on their patch", t);
  for (const int i : kTetFaces[f])
    require(mesh.local_index(n.tet(), mesh.vertex(t, i)) >= 0, "neighbours share three vertices", t);
}

void check_tet(const TetMesh& mesh, TetId t) {
  require(mesh.alive(t), "tets of a ball are alive", t);
  const TetVertices v = mesh.vertices(t);
  for (const VertexId x : v) require(mesh.alive(x), "vertices are alive", t);
  require(orientation(mesh.point(v[0]), mesh.point(v[1]), mesh.point(v[2]), mesh.point(v[3])) > 0,
          "tets are positive", t);
  for (int f = 0; f < 4; ++f) check_face(mesh, t, f);
}

}  // namespace

void check_ball(Worker& w, VertexId v) {
  Ball ball;
  if (gather_ball(w.mesh, w.claims, v, ball) != Verdict::accepted) return;
  for (const auto& [t, local] : ball.tets) check_tet(w.mesh, t);
}

}  // namespace weft::meshing
