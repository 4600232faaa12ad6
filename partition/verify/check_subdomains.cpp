// Copies of subdomains become pieces, which check_pieces() knows how to check.
#include "partition/verify/check_subdomains.h"

#include <algorithm>
#include <cstring>
#include <sstream>
#include <string>
#include <unordered_map>

#include "meshing/kernel/tet_mesh_arrays.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::partition {
namespace {

using meshing::Problems;
using meshing::TetFace;
using meshing::TetId;
using meshing::TetMesh;
using meshing::VertexId;

void check_table(const Subdomain& s, Problems& problems) {
  const TetMesh& mesh = *s.mesh;
  const auto add = [&](GlobalId id, const auto&... what) {
    problems.add("subdomain ", s.id.value, ": vertex ", id, ": ", what...);
  };
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
    const VertexId v = s.interface.local(i);
    const GlobalId id = s.interface.id(i);
    if (!v.valid() || v.value >= mesh.vertex_slots() || !mesh.alive(v) || s.global_id(v) != id)
      add(id, "of the interface, is not in the mesh");
    else if (!mesh.frozen(v))
      add(id, "of the interface, is not frozen");
    if (s.interface.held_by(i, s.id)) add(id, "names its own subdomain as another holder");
  }
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (const VertexId v(i);
        mesh.alive(v) && mesh.frozen(v) && s.interface.find(s.global_id(v)) == Interface::kNone)
      add(s.global_id(v), "is frozen, but not of the interface");
}

void check_tet(const Subdomain& s, const Geometry& geometry, TetId t, Problems& problems) {
  const TetMesh& mesh = *s.mesh;
  for (int f = 0; f < 4; ++f) {
    const TetFace n = mesh.neighbour(t, f);
    if (n.valid()) {
      if (!mesh.alive(n.tet()) || mesh.neighbour(n.tet(), n.face()) != TetFace(t, f))
        problems.add("subdomain ", s.id.value, ": tet ", t, ": its neighbour beyond face ", f,
                     " does not know it");
      continue;
    }
    const meshing::PatchId patch = mesh.patch(t, f);
    if (patch.valid() && !geometry.patch_inner[patch.value]) continue;
    for (const int k : meshing::kTetFaces[f])
      if (const VertexId v = mesh.vertex(t, k); !mesh.frozen(v))
        problems.add("subdomain ", s.id.value, ": vertex ", s.global_id(v),
                     ": of a face to another subdomain, is not frozen");
  }
}

MeshPiece piece_of(const Subdomain& s, const Geometry& geometry) {
  Subdomain copy;
  copy.id = s.id;
  copy.interface = s.interface;
  copy.surface = s.surface;
  copy.mesh = meshing::from_arrays(meshing::to_arrays(*s.mesh), s.mesh->vertex_slots() + 1,
                                   s.mesh->tet_slots() + 1, meshing::Pages::small);
  return make_piece(copy, geometry.surface, geometry.patch_required);
}

}  // namespace

void check_interface(const Subdomain& s, const Geometry& geometry, Problems& problems) {
  check_table(s, problems);
  for (std::uint32_t i = 0; i < s.mesh->tet_slots(); ++i)
    if (s.mesh->alive(TetId(i))) check_tet(s, geometry, TetId(i), problems);
}

PiecesReport check_subdomains(Peers& peers, std::span<const Subdomain* const> mine, const Geometry& geometry,
                              const std::optional<ExpectedTotals>& expected, int max_problems) {
  PiecesReport report;
  Problems problems(static_cast<std::size_t>(std::max(max_problems, 0)));
  for (const Subdomain* s : mine) check_interface(*s, geometry, problems);
  gather_problems(peers, std::move(problems), true, report);
  if (!report.ok()) return report;
  std::vector<MeshPiece> pieces;
  for (const Subdomain* s : mine) pieces.push_back(piece_of(*s, geometry));
  return check_pieces(peers, pieces, expected, max_problems, true);
}

void throw_if_violated(const PiecesReport& report, const std::string& when) {
  if (report.ok()) return;
  std::ostringstream text;
  text << "an invariant of the subdomains is violated " << when;
  for (const std::string& problem : report.problems) text << "\n  " << problem;
  if (report.num_problems > report.problems.size())
    text << "\n  and " << report.num_problems - report.problems.size() << " more";
  throw InvariantViolation(text.str());
}

InterfaceSnapshot::InterfaceSnapshot(const Subdomain& s) {
  for (std::uint32_t i = 0; i < s.interface.size(); ++i)
    vertices_.push_back({s.interface.id(i), s.mesh->point(s.interface.local(i))});
}

/// By the mesh alone: the table of the interface may be wrong too.
void InterfaceSnapshot::check(const Subdomain& s) const {
  const TetMesh& mesh = *s.mesh;
  std::unordered_map<GlobalId, VertexId> now;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (const VertexId v(i); mesh.alive(v) && mesh.frozen(v)) now.emplace(s.global_id(v), v);
  for (const Vertex& v : vertices_) {
    const auto at = now.find(v.id);
    const bool here = at != now.end();
    if (here && std::memcmp(&mesh.point(at->second), &v.point, sizeof v.point) == 0) continue;
    std::ostringstream text;
    text << "an invariant is violated: subdomain " << s.id.value << ": vertex " << v.id
         << " of the interface " << (here ? "moved" : "vanished or was thawed") << " during an adaptation";
    throw InvariantViolation(text.str());
  }
}

ExpectedTotals totals_to_keep(const PiecesReport& at_first, const Geometry& geometry, double distance) {
  const auto planar = [](const meshing::Patch& p) { return p.planar; };
  const auto straight = [](const meshing::Curve& c) { return c.straight; };
  ExpectedTotals totals;
  totals.volume = at_first.volume;
  if (std::ranges::all_of(geometry.surface.patches(), planar) &&
      std::ranges::all_of(geometry.surface.curves(), straight)) {
    totals.area_by_ref = at_first.area_by_ref;
    return totals;
  }
  double area = 0;
  for (const auto& [ref, of_ref] : at_first.area_by_ref) area += of_ref;
  totals.volume_tolerance = 2 * distance * area;  // the area may grow too
  totals.areas_known = false;
  return totals;
}

}  // namespace weft::partition
