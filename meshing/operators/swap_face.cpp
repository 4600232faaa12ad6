// Face swap: two tets become three.
#include "meshing/operators/swap_face.h"

#include "meshing/operators/check_cavity.h"
#include "meshing/operators/swap_common.h"

namespace weft::meshing {

Verdict swap_face(Worker& w, TetId t, int face) {
  TetMesh& mesh = w.mesh;
  const TetFace across = mesh.neighbour(t, face);
  if (!across.valid() || mesh.patch(t, face).valid()) return Verdict::breaks_classification;
  const TetId u = across.tet();
  const VertexId p = mesh.vertex(t, face), q = mesh.vertex(u, across.face());
  if (const Verdict r = w.claims.claim(q); r != Verdict::accepted) return r;
  std::array<VertexId, 3> f;
  for (int i = 0; i < 3; ++i) f[i] = mesh.vertex(t, kTetFaces[face][i]);
  const double enough = enough_for_swap(std::min(mesh.quality(t), mesh.quality(u)));
  std::array<double, 3> quality;
  const Corner cp = w.corner(p), cq = w.corner(q);
  for (int i = 0; i < 3; ++i) {
    if (mesh.all_on_curved_boundary({q, p, f[i], f[(i + 1) % 3]})) return Verdict::breaks_topology;
    quality[i] = judge_quality_above(enough, w.mean(), cq, cp, w.corner(f[i]), w.corner(f[(i + 1) % 3]));
    if (quality[i] < 0) return Verdict::inverts;
    if (quality[i] <= enough) return Verdict::worsens_quality;
  }
  if (!w.secure(1, 0)) return Verdict::too_large;
  // New tet i is (q, p, f_i, f_i+1): its face opposite q is the face of t over edge i, that opposite p is
  // u's.
  std::array<OuterFace, 3> outer_t, outer_u;
  for (int i = 0; i < 3; ++i) {
    const int it = mesh.local_index(t, f[(i + 2) % 3]), iu = mesh.local_index(u, f[(i + 2) % 3]);
    outer_t[i] = outer_face(mesh, t, it);
    outer_u[i] = outer_face(mesh, u, iu);
  }
  const std::array<TetId, 3> tets = {t, u, w.new_tet()};
  const std::int32_t ref = mesh.ref(t);
  for (int i = 0; i < 3; ++i) {
    const TetId n = tets[i];
    mesh.set_vertices(n, {q, p, f[i], f[(i + 1) % 3]});
    mesh.set_ref(n, ref);
    mesh.set_quality(n, static_cast<float>(quality[i]));
    mesh.mark(n, kAllTetMarks);
    mesh.set_tet_of(f[i], n);
  }
  for (int i = 0; i < 3; ++i) {
    const TetId n = tets[i];
    mesh.glue(TetFace(n, 0), outer_t[i].neighbour);
    mesh.set_neighbour(n, 0, outer_t[i].neighbour);
    mesh.set_patch(n, 0, outer_t[i].patch);
    mesh.glue(TetFace(n, 1), outer_u[i].neighbour);
    mesh.set_neighbour(n, 1, outer_u[i].neighbour);
    mesh.set_patch(n, 1, outer_u[i].patch);
    mesh.glue(TetFace(n, 2), TetFace(tets[(i + 1) % 3], 3));  // faces (q, p, f_i+1)
    mesh.set_patch(n, 2, PatchId());
    mesh.set_patch(n, 3, PatchId());
  }
  for (const VertexId v : {p, q}) mesh.set_tet_of(v, tets[0]);
  mark_if_short(w, p, q);
  for (const VertexId v : {p, q, f[0], f[1], f[2]}) mesh.touch(v);
  check_cavity(w, p);
  return Verdict::accepted;
}

}  // namespace weft::meshing
