// From a start to a subdomain, names of new vertices, and the piece that is left at the end.
#include "partition/subdomain/subdomain.h"

#include <utility>

#include "meshing/kernel/import_mesh.h"
#include "meshing/kernel/renumber.h"
#include "meshing/mesh/adjacency.h"

namespace weft::partition {

using meshing::PatchId;
using meshing::TetFace;
using meshing::TetId;
using meshing::VertexId;

namespace {

void fill_vertices(const SubdomainStart& s, meshing::TetMesh& mesh) {
  mesh.take_vertex_slots(static_cast<std::uint32_t>(s.points.size()));
  for (std::uint32_t i = 0; i < s.points.size(); ++i) {
    const VertexId v(i);
    mesh.set_point(v, s.points[i]);
    mesh.set_ref(v, s.point_refs[i]);
    mesh.set_metric(v, s.log_metrics[i], meshing::exp_fast(s.log_metrics[i]));
    mesh.set_label(v, s.ids[i].value());
    mesh.set_kind(v, s.kinds[i]);
    mesh.set_flags(v, s.flags[i]);
    mesh.set_surface_hint(v, s.surface_hints[i]);
  }
}

void fill_tets(const SubdomainStart& s, const meshing::Adjacency& adjacency, meshing::TetMesh& mesh) {
  mesh.take_tet_slots(static_cast<std::uint32_t>(s.tets.size()));
  for (std::uint32_t i = 0; i < s.tets.size(); ++i) {
    const TetId t(i);
    for (int f = 0; f < 4; ++f) {
      const VertexId v(s.tets[i][f]);
      mesh.set_vertex(t, f, v);
      mesh.set_neighbour(t, f, TetFace(adjacency.neighbours[i][f]));
      mesh.set_tet_of(v, t);
      mesh.set_background_hint(
          v, i);  // the background's tets are these, in the same order, if it is not another mesh
    }
    mesh.set_ref(t, s.tet_refs[i]);
    mesh.set_quality(t, 1);  // not judged yet
  }
  for (const auto& b : s.boundary_faces) mesh.set_patch(TetId(b.tet), static_cast<int>(b.face), b.patch);
  for (const auto& e : s.feature_edges) mesh.set_curve(VertexId(e.ends[0]), VertexId(e.ends[1]), e.curve);
}

BackgroundStore background_of(const SubdomainStart& s, const meshing::Adjacency& adjacency) {
  if (s.background_places.empty()) return {s.subdomain, s.points, s.log_metrics, s.ids, s.tets, adjacency};
  BackgroundStore store;
  store.add(s.background);
  return store;
}

}  // namespace

Subdomain::Subdomain(const SubdomainStart& start, std::size_t capacity)
    : id(start.subdomain),
      next_local(std::uint64_t{1} << (GlobalId::kLocalBits - 1)),  // beyond all numbers of the input
      mesh(meshing::reserve_tet_mesh({vertex_capacity(capacity), capacity},
                                     {start.points.size(), start.tets.size()}, meshing::Pages::small)) {
  const meshing::Adjacency adjacency = meshing::build_adjacency(start.tets, start.points.size());
  fill_vertices(start, *mesh);
  fill_tets(start, adjacency, *mesh);
  background = background_of(start, adjacency);
  surface.add(start.surface);
  for (std::uint32_t v = 0; v < start.background_places.size(); ++v)
    mesh->set_background_hint(VertexId(v), background.tet_of(start.background_places[v]));
  std::vector<Holder> lines;
  for (const auto& [vertex, other] : start.shared) lines.push_back({start.ids[vertex], other});
  interface = Interface(std::move(lines));
  for (const auto& [vertex, other] : start.shared) {
    interface.set_local(interface.find(start.ids[vertex]), VertexId(vertex));
    mesh->freeze(VertexId(vertex));
  }
}

void name_new_vertices(Subdomain& s) {
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i)
    if (s.mesh->alive(VertexId(i)) && s.mesh->label(VertexId(i)) == 0)
      s.mesh->set_label(VertexId(i), GlobalId(s.id, s.next_local++).value());
}

std::uint64_t count_tets(const Subdomain& s) {
  std::uint64_t tets = 0;
  for (std::uint32_t t = 0; t < s.mesh->tet_slots(); ++t) tets += s.mesh->alive(meshing::TetId(t));
  return tets;
}

void begin_next_phase(Subdomain& s) {
  ++s.phase;
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i)
    if (const VertexId v(i); s.mesh->alive(v))
      s.mesh->set_flags(v, s.mesh->flags(v) & static_cast<std::uint8_t>(~(kHasBeenFree | kWasInterface)));
}

namespace {

bool is_located(const Subdomain& s) {
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
    const VertexId v = s.interface.local(i);
    if (!v.valid() || v.value >= s.mesh->vertex_slots() || !s.mesh->alive(v) ||
        s.global_id(v) != s.interface.id(i))
      return false;
  }
  return true;
}

}  // namespace

void locate_interface(Subdomain& s) {
  if (is_located(s)) return;
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) s.interface.set_local(i, VertexId());
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i) {
    const VertexId v(i);
    if (!s.mesh->alive(v) || !s.mesh->frozen(v)) continue;
    if (const std::uint32_t at = s.interface.find(s.global_id(v)); at != Interface::kNone)
      s.interface.set_local(at, v);
  }
}

MeshPiece make_piece(Subdomain& s, const meshing::Surface& surface, const std::vector<bool>& patch_required,
                     PieceOrder order) {
  const bool is_kept = order == PieceOrder::kept_if_good && !surface.model() && meshing::is_in_order(*s.mesh);
  if (!is_kept) meshing::renumber_along_curve(*s.mesh);
  locate_interface(s);
  MeshPiece piece;
  piece.subdomain = s.id;
  meshing::export_mesh(*s.mesh, surface.part(s.surface), patch_required, piece.mesh, piece.log_metrics);
  std::vector<std::uint32_t> places(s.mesh->vertex_slots());
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    if (!s.mesh->alive(VertexId(i))) continue;
    places[i] = static_cast<std::uint32_t>(piece.ids.size());
    piece.ids.push_back(s.global_id(VertexId(i)));
  }
  for (std::uint32_t i = 0; i < s.interface.size(); ++i)
    for (const Holder& h : s.interface.others(i))
      piece.shared.push_back({places[s.interface.local(i).value], h.subdomain});
  std::sort(piece.shared.begin(), piece.shared.end());
  return piece;
}

}  // namespace weft::partition
