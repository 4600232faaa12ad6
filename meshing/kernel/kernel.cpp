// Classification of an edge from the faces of its shell.
#include "meshing/kernel/kernel.h"

namespace weft::meshing {

EdgeClass classify(const TetMesh& mesh, const Shell& shell) {
  const VertexKind ka = mesh.kind(shell.a), kb = mesh.kind(shell.b);
  EdgeClass c;
  if (ka == VertexKind::interior || kb == VertexKind::interior) return c;
  c.curve = mesh.curve(shell.a, shell.b);
  // Every face around the edge lies opposite r of one shell tet; an open shell's first face opposite s of its
  // first.
  for (int i = 0; i < shell.size && !c.patch.valid(); ++i)
    c.patch = mesh.patch(shell.tets[i].tet, shell.tets[i].r);
  if (!c.patch.valid() && !shell.closed) c.patch = mesh.patch(shell.tets[0].tet, shell.tets[0].s);
  c.kind = c.curve.valid() ? VertexKind::ridge : c.patch.valid() ? VertexKind::surface : VertexKind::interior;
  return c;
}

}  // namespace weft::meshing
