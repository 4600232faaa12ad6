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

/// What nobody reads of a dead slot packs to nothing where it is what the slot before has.
template <class... Array>
void repeat_before(std::uint32_t slot, Array&... arrays) {
  ((arrays[slot] = arrays[slot - 1]), ...);
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
    for (int f = 0; f < 4; ++f) {
      a.tets[i][f] = mesh.vertex(t, f).value;
      a.patches[i][f] = mesh.patch(t, f).value;
    }
    a.tet_refs[i] = mesh.ref(t);
    a.qualities[i] = mesh.quality(t);
    a.tet_marks[i] = mesh.marks(t);
    if (i > 0 && !mesh.alive(t)) repeat_before(i, a.patches, a.tet_refs, a.qualities);
  }
}

void copy_vertices(const TetMesh& mesh, TetMeshArrays& a) {
  const std::uint32_t n = mesh.vertex_slots();
  a.points.reserve(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const VertexId v(i);
    a.points.push_back(mesh.point(v));
    a.log_metrics.push_back(mesh.log_metric(v));
    if (i > 0 && !mesh.alive(v)) repeat_before(i, a.points, a.log_metrics);
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
