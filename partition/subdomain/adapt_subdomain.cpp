// The kernel called on a subdomain.
#include "partition/subdomain/adapt_subdomain.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "meshing/kernel/quality.h"
#include "meshing/mesh/tet_tables.h"
#include "meshing/metric/expectations.h"

namespace weft::partition {

using meshing::TetId;
using meshing::VertexId;

namespace {

bool has_tets(const meshing::TetMesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (mesh.alive(TetId(i))) return true;
  return false;
}

bool has_fresh_tets(const meshing::TetMesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if ((mesh.marks(TetId(i)) & meshing::kFresh) != 0 && mesh.alive(TetId(i))) return true;
  return false;
}

void remember_who_was_free(meshing::TetMesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i)) && !mesh.frozen(VertexId(i)))
      mesh.set_flags(VertexId(i), mesh.flags(VertexId(i)) | kHasBeenFree);
}

/// Marks frozen vertices, by slot, around which something is wrong that only an adaptation with all of them
/// free can mend: a poor tet at one, an edge of the interface that is too long or far too short. Edges a
/// little too short are left in any mesh, as their collapse would make others too long.
std::vector<std::uint8_t> frozen_at_fault(const meshing::TetMesh& mesh, const meshing::Limits& limits) {
  constexpr double kFarTooShort = 0.7;
  std::vector<std::uint8_t> at_fault(mesh.vertex_slots(), 0);
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    if (!mesh.alive(TetId(i))) continue;
    const meshing::TetVertices v = mesh.vertices(TetId(i));
    if (mesh.quality(TetId(i)) < static_cast<float>(meshing::kFair))
      for (const VertexId x : v) at_fault[x.value] = 1;
    if (mesh.frozen(v[0]) + mesh.frozen(v[1]) + mesh.frozen(v[2]) + mesh.frozen(v[3]) < 2) continue;
    for (const auto& e : meshing::kTetEdges) {
      const VertexId a = v[e[0]], b = v[e[1]];
      if (!mesh.frozen(a) || !mesh.frozen(b)) continue;
      const meshing::MetricLength length = meshing::edge_between(mesh, a, b);
      if (length.above(limits.long_edge) || length.below(kFarTooShort * limits.short_edge))
        at_fault[a.value] = at_fault[b.value] = 1;
    }
  }
  return at_fault;
}

/// Where nearly all was right before, the rest of the interface is as good as what has been free.
void excuse_what_is_right(meshing::TetMesh& mesh, const meshing::Limits& limits) {
  const std::vector<std::uint8_t> at_fault = frozen_at_fault(mesh, limits);
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i)) && mesh.frozen(VertexId(i)) && !at_fault[i])
      mesh.set_flags(VertexId(i), mesh.flags(VertexId(i)) | kHasBeenFree);
}

meshing::Room room_for(std::uint64_t tets) {
  const std::uint64_t most = std::min<std::uint64_t>(tets, meshing::kMostTets);
  return {vertex_capacity(most), most};
}

}  // namespace

std::size_t tet_slots_for(double predicted, std::uint64_t tets) {
  const double wanted = 1.5 * predicted + 2 * static_cast<double>(tets) + 1e4;
  return static_cast<std::size_t>(std::min(wanted, static_cast<double>(meshing::kMostTets)));
}

void make_room(Subdomain& s, std::uint64_t more) {
  // Vertices have half as many slots as tets (vertex_capacity), and mostly need a fifth.
  const std::uint64_t needed =
      std::max<std::uint64_t>(s.mesh->tet_slots(), 2 * s.mesh->vertex_slots()) + more;
  if (needed <= s.mesh->tet_capacity()) return;
  try {
    s.mesh->reserve(room_for(2 * needed));
  } catch (const meshing::NoAddressSpace&) {
    s.mesh->reserve(room_for(needed));
  }
}

meshing::AdaptReport adapt_subdomain(Subdomain& s, const meshing::Surface& surface,
                                     const meshing::Limits& limits, meshing::Extent extent,
                                     const meshing::AdaptOptions& options,
                                     const meshing::BeforeLevel& before_level) {
  meshing::AdaptReport report;
  if (!has_tets(*s.mesh)) return report;
  if (extent == meshing::Extent::fresh && !has_fresh_tets(*s.mesh)) return report;
  const meshing::Surface here = surface.part(s.surface);
  meshing::Kernel kernel{*s.mesh, s.background.background(), here, limits};
  meshing::adapt_in_place(kernel, options, extent, report, before_level);
  remember_who_was_free(*s.mesh);
  constexpr double kNearlyRight = 0.1;
  if (extent == meshing::Extent::everything && report.share_wrong < kNearlyRight)
    excuse_what_is_right(*s.mesh, limits);
  name_new_vertices(s);
  locate_interface(s);
  return report;
}

meshing::NonconformingParts count_nonconforming(const Subdomain& s) {
  constexpr std::uint32_t kSample = 64;  // vertices: about five hundred edges of each subdomain
  const std::uint32_t one_in = std::bit_floor(std::max(s.mesh->vertex_slots() / kSample, 1u));
  return meshing::count_nonconforming(*s.mesh, meshing::kFrozen | kWasInterface, one_in);
}

}  // namespace weft::partition
