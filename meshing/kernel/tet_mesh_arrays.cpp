// Copies between the kernel's mesh and plain vectors.
#include "meshing/kernel/tet_mesh_arrays.h"

#include "meshing/mesh/face_matcher.h"

namespace weft::meshing {
namespace {

void glue_all(TetMesh& mesh) {
  FaceMatcher faces(mesh.vertex_slots());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    for (int f = 0; f < 4; ++f) mesh.set_neighbour(TetId(i), f, TetFace());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    const TetVertices v = mesh.vertices(t);
    for (int f = 0; f < 4; ++f) {
      const auto& corners = kTetFaces[f];
      const TetFace face(t, f);
      const TetFace other(
          faces.match({v[corners[0]].value, v[corners[1]].value, v[corners[2]].value}, face.code));
      if (other.valid()) mesh.glue(face, other);
    }
  }
}

void copy_tets(const TetMesh& mesh, TetMeshArrays& a) {
  const std::uint32_t n = mesh.tet_slots();
  a.tets.resize(n);
  a.patches.resize(n);
  a.tet_refs.resize(n);
  a.qualities.resize(n);
  a.tet_marks.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const TetId t(i);
    for (int f = 0; f < 4; ++f) a.tets[i][f] = mesh.vertex(t, f).value;
    a.tet_marks[i] = mesh.marks(t);
    const std::uint32_t from = mesh.alive(t) || i == 0 ? i : i - 1;
    if (from == i) {
      for (int f = 0; f < 4; ++f) a.patches[i][f] = mesh.patch(t, f).value;
      a.tet_refs[i] = mesh.ref(t);
      a.qualities[i] = mesh.quality(t);
    } else {
      a.patches[i] = a.patches[from];
      a.tet_refs[i] = a.tet_refs[from];
      a.qualities[i] = a.qualities[from];
    }
  }
}

void copy_vertices(const TetMesh& mesh, TetMeshArrays& a) {
  const std::uint32_t n = mesh.vertex_slots();
  a.points.reserve(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const VertexId v(i);
    const bool dead = !mesh.alive(v) && i > 0;
    a.points.push_back(dead ? a.points[i - 1] : mesh.point(v));
    a.log_metrics.push_back(dead ? a.log_metrics[i - 1] : mesh.log_metric(v));
    a.labels.push_back(mesh.label(v));
    a.vertex_refs.push_back(mesh.ref(v));
    a.vertex_tets.push_back(mesh.tet_of(v).value);
    a.background_hints.push_back(mesh.background_hint(v));
    a.surface_hints.push_back(mesh.surface_hint(v));
    a.kinds.push_back(static_cast<std::uint8_t>(mesh.kind(v)));
    a.flags.push_back(mesh.flags(v));
    a.vertex_marks.push_back(mesh.marks(v));
  }
}

}  // namespace

TetMeshArrays to_arrays(const TetMesh& mesh) {
  TetMeshArrays a;
  copy_tets(mesh, a);
  copy_vertices(mesh, a);
  a.features = mesh.feature_edges();
  return a;
}

std::unique_ptr<TetMesh> from_arrays(const TetMeshArrays& a, std::size_t vertex_capacity,
                                     std::size_t tet_capacity, Pages pages) {
  auto mesh = reserve_tet_mesh({vertex_capacity, tet_capacity}, {a.points.size(), a.tets.size()}, pages);
  mesh->take_vertex_slots(static_cast<std::uint32_t>(a.points.size()));
  mesh->take_tet_slots(static_cast<std::uint32_t>(a.tets.size()));
  for (std::uint32_t i = 0; i < a.points.size(); ++i) {
    const VertexId v(i);
    mesh->set_point(v, a.points[i]);
    mesh->set_metric(v, a.log_metrics[i], exp_fast(a.log_metrics[i]));
    mesh->set_label(v, a.labels[i]);
    mesh->set_ref(v, a.vertex_refs[i]);
    mesh->set_background_hint(v, a.background_hints[i]);
    mesh->set_surface_hint(v, a.surface_hints[i]);
    mesh->set_kind(v, static_cast<VertexKind>(a.kinds[i]));
    mesh->set_flags(v, a.flags[i]);
    mesh->mark(v, a.vertex_marks[i]);
    mesh->set_tet_of(v, TetId(a.vertex_tets[i]));
  }
  for (std::uint32_t i = 0; i < a.tets.size(); ++i) {
    const TetId t(i);
    for (int f = 0; f < 4; ++f) {
      mesh->set_vertex(t, f, VertexId(a.tets[i][f]));
      mesh->set_patch(t, f, PatchId(a.patches[i][f]));
    }
    mesh->set_ref(t, a.tet_refs[i]);
    mesh->set_quality(t, a.qualities[i]);
    mesh->mark(t, a.tet_marks[i]);
  }
  glue_all(*mesh);
  for (const TetMesh::FeatureEdge& e : a.features) mesh->set_curve(e.a, e.b, e.curve);
  return mesh;
}

}  // namespace weft::meshing
