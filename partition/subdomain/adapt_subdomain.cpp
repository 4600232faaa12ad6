// The kernel called on a subdomain.
#include "partition/subdomain/adapt_subdomain.h"

#include <algorithm>
#include <bit>

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
    if (mesh.alive(TetId(i)) && mesh.marks(TetId(i)) & meshing::kFresh) return true;
  return false;
}

void remember_who_was_free(meshing::TetMesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i)) && !mesh.frozen(VertexId(i)))
      mesh.set_flags(VertexId(i), mesh.flags(VertexId(i)) | kHasBeenFree);
}

}  // namespace

meshing::AdaptReport adapt_subdomain(Subdomain& s, const meshing::Surface& surface,
                                     const meshing::Limits& limits, meshing::Extent extent,
                                     const meshing::AdaptOptions& options,
                                     const meshing::BeforeLevel& before_level) {
  meshing::AdaptReport report;
  if (!has_tets(*s.mesh)) return report;
  if (extent == meshing::Extent::fresh && !has_fresh_tets(*s.mesh)) return report;
  meshing::Kernel kernel{*s.mesh, s.background.background(), surface, limits};
  meshing::adapt_in_place(kernel, options, extent, report, before_level);
  remember_who_was_free(*s.mesh);
  name_new_vertices(s);
  locate_interface(s);
  return report;
}

meshing::NonconformingParts count_nonconforming(const Subdomain& s) {
  constexpr std::uint32_t kSample = 256;  // vertices: about two thousand edges
  const std::uint32_t one_in = std::bit_floor(std::max(s.mesh->vertex_slots() / kSample, 1u));
  return meshing::count_nonconforming(*s.mesh, meshing::kFrozen | kWasInterface, one_in);
}

}  // namespace weft::partition
