// Layers of tets around wanted vertices, each for the first in the order of priorities.
#include "partition/shift/choice.h"

#include <algorithm>
#include <utility>

#include "partition/subdomain/tets_at.h"

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::TetVertices;
using meshing::VertexId;

Choice::Choice(const Subdomain& s, const Priority& mine, std::span<const Proposal> proposals)
    : s_(s), mesh_(*s.mesh), order_(mine, priorities_of(proposals)) {}

Chosen Choice::choose(std::span<const GlobalId> wanted, std::span<const Proposal> proposals,
                      const ShiftOptions& options) {
  vertex_.assign(mesh_.vertex_slots(), kNobody);
  tet_.assign(mesh_.tet_slots(), kNobody);
  bool any_leave = seed(wanted);
  for (const Proposal& p : proposals) any_leave |= seed(p.wants);
  Chosen chosen;
  if (any_leave) {
    take_at_vertices();
    for (int layer = 0; layer < options.layers && !taken_.empty(); ++layer) {
      if (options.by_faces) {
        take_across_faces();
      } else {
        spread_to_vertices();
        take_at_vertices();
      }
    }
    for (std::uint32_t i = 0; i < tet_.size(); ++i) {
      if (tet_[i] == order_.self()) tet_[i] = kNobody;
      if (tet_[i] != kNobody) chosen.leaving.emplace_back(i);
    }
  }
  chosen.to = std::move(tet_);
  return chosen;
}

/// The holder of highest priority receives a wanted vertex. Returns whether any goes to another subdomain.
bool Choice::seed(std::span<const GlobalId> wanted) {
  bool any_leave = false;
  std::uint32_t i = 0;
  for (const GlobalId id : wanted) {  // both are sorted
    while (s_.interface.id(i) < id) ++i;
    const Place receiver = order_.receiver(s_.interface.others(i));
    vertex_[s_.interface.local(i).value] = receiver;
    any_leave |= receiver != order_.self();
  }
  return any_leave;
}

/// Every tet that has no subdomain yet takes the first among its vertices'.
void Choice::take_at_vertices() {
  taken_.clear();
  for_each_tet_at(mesh_, vertex_, [&](TetId t, const TetVertices& vertices) {
    if (tet_[t.value] != kNobody) return;
    for (const VertexId v : vertices) tet_[t.value] = std::max(tet_[t.value], vertex_[v.value]);
    taken_.push_back(t.value);
  });
}

/// Vertices without a subdomain take the first among the tets that were taken last.
void Choice::spread_to_vertices() {
  reached_.clear();
  of_reached_.resize(vertex_.size(), kNobody);
  for (const std::uint32_t i : taken_)
    for (const VertexId v : mesh_.vertices(TetId(i))) {
      if (vertex_[v.value] != kNobody) continue;
      Place& first = of_reached_[v.value];
      if (first == kNobody) reached_.push_back(v.value);
      first = std::max(first, tet_[i]);
    }
  for (const std::uint32_t v : reached_) vertex_[v] = std::exchange(of_reached_[v], kNobody);
}

/// The same from tet to tet through faces.
void Choice::take_across_faces() {
  next_.clear();
  for (const std::uint32_t i : taken_)
    for (int f = 0; f < 4; ++f)
      if (const TetFace n = mesh_.neighbour(TetId(i), f); n.valid() && tet_[n.tet().value] == kNobody)
        next_.push_back({n.tet().value, tet_[i]});
  taken_.clear();
  for (const auto& [t, r] : next_) {
    if (tet_[t] == kNobody) taken_.push_back(t);
    tet_[t] = std::max(tet_[t], r);
  }
}

}  // namespace weft::partition
