// Proposals, and the choice of the tets that leave.
#include <algorithm>

#include "meshing/base/place_in.h"
#include "meshing/metric/expectations.h"
#include "partition/shift/hand_over.h"
#include "partition/shift/shift.h"
#include "partition/subdomain/tets_at.h"

namespace weft::partition {

using meshing::TetId;
using meshing::TetMesh;
using meshing::VertexId;

namespace {

bool never_free(const TetMesh& mesh, VertexId v) { return !(mesh.flags(v) & kHasBeenFree); }

/// Marks vertices of poor tets and of those that touch them, by slot: any that is frozen may be in the way.
/// None where much of the mesh is poor: then no mesh fits the metric, and the interface is not what is wrong.
std::vector<std::uint8_t> near_poor_tets(const Subdomain& s) {
  const TetMesh& mesh = *s.mesh;
  std::vector<std::uint8_t> at(mesh.vertex_slots(), 0);
  std::uint64_t poor = 0;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {  // most are good: nothing else of them is read
    if (mesh.quality(TetId(i)) >= static_cast<float>(meshing::kShiftBelow) || !mesh.alive(TetId(i))) continue;
    ++poor;
    for (const VertexId v : mesh.vertices(TetId(i))) at[v.value] = 1;
  }
  if (poor == 0) return at;
  if (static_cast<double>(poor) > meshing::kMisfitShare * static_cast<double>(count_tets(s)))
    return std::vector<std::uint8_t>(at.size(), 0);
  std::vector<std::uint8_t> near = at;
  for_each_tet_at(mesh, at, [&](TetId, const meshing::TetVertices& vertices) {
    for (const VertexId v : vertices) near[v.value] = 1;
  });
  return near;
}

std::vector<std::uint32_t> surface_ids(const Subdomain& s) {
  std::vector<std::uint32_t> ids;
  for (const auto& piece : s.surface.all()) ids.push_back(piece->id);
  return ids;
}

/// One for each neighbour, with nothing in it.
std::vector<Parcel> empty_parcels(const Subdomain& s) {
  std::vector<Parcel> parcels(s.interface.neighbours().size());
  for (Parcel& p : parcels) p.from = s.id;
  return parcels;
}

}  // namespace

std::vector<Priority> priorities_of(std::span<const Proposal> proposals) {
  std::vector<Priority> priorities;
  for (const Proposal& p : proposals) priorities.push_back(p.priority);
  return priorities;
}

std::vector<GlobalId> wanted(const Subdomain& s, std::uint64_t round) {
  const std::vector<std::uint8_t> poor =
      round < kRoundsForQuality ? near_poor_tets(s) : std::vector<std::uint8_t>(s.mesh->vertex_slots(), 0);
  std::vector<GlobalId> ids;
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
    const VertexId v = s.interface.local(i);
    if (never_free(*s.mesh, v) || poor[v.value]) ids.push_back(s.interface.id(i));
  }
  return ids;
}

std::vector<Proposal> propose(const Subdomain& s, const Priority& mine, std::span<const GlobalId> wanted) {
  const auto neighbours = s.interface.neighbours();
  std::vector<Proposal> proposals(neighbours.size(),
                                  Proposal{mine, {}, s.background.piece_ids(), surface_ids(s)});
  std::uint32_t i = 0;
  for (const GlobalId id : wanted) {
    while (s.interface.id(i) < id) ++i;
    for (const Holder& h : s.interface.others(i))
      proposals[meshing::place_in(neighbours, h.subdomain)].wants.push_back(id);
  }
  return proposals;
}

std::size_t vertices_received(const Subdomain& s, const ReceiverOrder& order,
                              std::span<const GlobalId> wanted, std::span<const Proposal> proposals) {
  std::vector<std::uint8_t> received(s.interface.size(), 0);  // several may want the same one
  const auto note = [&](std::span<const GlobalId> ids) {
    std::uint32_t i = 0;
    for (const GlobalId id : ids) {  // both are sorted
      while (s.interface.id(i) < id) ++i;
      received[i] = order.receiver(s.interface.others(i)) == order.self();
    }
  };
  note(wanted);
  for (const Proposal& p : proposals) note(p.wants);
  return static_cast<std::size_t>(std::ranges::count(received, 1));
}

std::vector<Parcel> gather(Subdomain& s, const Priority& mine, std::span<const GlobalId> wanted,
                           std::span<const Proposal> proposals, const ShiftOptions& options) {
  s.departures.clear();
  s.frozen_since.clear();
  const auto wants_nothing = [](const Proposal& p) { return p.wants.empty(); };
  if (wanted.empty() && std::all_of(proposals.begin(), proposals.end(), wants_nothing))
    return empty_parcels(s);
  Choice choice(s, mine, proposals);
  const Chosen chosen = choice.choose(wanted, proposals, options);
  if (chosen.leaving.empty()) return empty_parcels(s);
  const auto neighbours = s.interface.neighbours();
  std::vector<Receiver> receivers;
  for (std::size_t n = 0; n < neighbours.size(); ++n)
    receivers.push_back({neighbours[n], proposals[n].pieces, proposals[n].surface, {}});
  return hand_over(s, choice.order(), chosen, receivers);
}

}  // namespace weft::partition
