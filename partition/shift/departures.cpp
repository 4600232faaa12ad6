// One look at the tets that leave and one at those that stay.
#include "partition/shift/departures.h"

#include <algorithm>
#include <span>
#include <unordered_set>

#include "partition/subdomain/tets_at.h"

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::TetMesh;
using meshing::TetVertices;
using meshing::VertexId;
using meshing::VertexKind;

namespace {

/// Collects where the tets around vertices go.
class Targets {
 public:
  Targets(std::uint32_t vertex_slots, const std::vector<std::uint32_t>& interface_index)
      : interface_index_(interface_index), last_(vertex_slots, kNobody), several_(vertex_slots, 0) {}

  bool known(VertexId v) const { return last_[v.value] != kNobody; }
  /// By slot: kNobody where not known.
  const std::vector<Place>& last() const { return last_; }

  void note(VertexId v, Place to) {
    Place& last = last_[v.value];  // neighbours in the arrays mostly go the same way
    if (last == to) return;
    if (last == kNobody) {
      vertices_.push_back(v.value);
      if (interface_index_[v.value] != Interface::kNone) several_[v.value] = 1;
    } else if (!several_[v.value]) {
      several_[v.value] = 1;
      found_.push_back({v.value, last});
    }
    if (several_[v.value]) found_.push_back({v.value, to});
    last = to;
  }

  std::vector<std::uint32_t> take_vertices() { return std::move(vertices_); }
  std::vector<std::uint8_t> take_several() { return std::move(several_); }
  struct Found {
    std::uint32_t vertex;
    Place to;
  };
  std::span<const Found> found() const { return found_; }

 private:
  const std::vector<std::uint32_t>& interface_index_;
  std::vector<Place> last_;
  std::vector<std::uint8_t> several_;  ///< to be listed: of the interface now, or after this
  std::vector<std::uint32_t> vertices_;
  std::vector<Found> found_;  ///< some repeatedly
};

std::uint64_t edge_key(VertexId a, VertexId b) {
  return std::uint64_t{std::min(a, b).value} << 32 | std::max(a, b).value;
}

/// Feature edges that no tet has any more are forgotten: vertices' places are used again.
void forget_features(TetMesh& mesh, const std::vector<std::uint32_t>& vertices) {
  std::vector<std::uint8_t> candidate(mesh.vertex_slots(), 0);
  bool any = false;
  for (const std::uint32_t v : vertices) {
    candidate[v] = mesh.kind(VertexId(v)) >= VertexKind::ridge;
    any |= candidate[v] != 0;
  }
  if (!any) return;
  std::unordered_set<std::uint64_t> absent;
  for (const TetMesh::FeatureEdge& e : mesh.feature_edges())
    if (candidate[e.a.value] && candidate[e.b.value]) absent.insert(edge_key(e.a, e.b));
  if (absent.empty()) return;
  for_each_tet_at(mesh, candidate, [&](TetId, const TetVertices& v) {
    if (candidate[v[0].value] + candidate[v[1].value] + candidate[v[2].value] + candidate[v[3].value] < 2)
      return;
    for (const auto& e : meshing::kTetEdges) absent.erase(edge_key(v[e[0]], v[e[1]]));
  });
  for (const std::uint64_t key : absent)
    mesh.set_curve(VertexId(static_cast<std::uint32_t>(key >> 32)), VertexId(static_cast<std::uint32_t>(key)),
                   meshing::CurveId());
}

}  // namespace

Departures find_departures(const Subdomain& s, const ReceiverOrder& order, const Chosen& chosen,
                           const std::vector<std::uint32_t>& interface_index) {
  const TetMesh& mesh = *s.mesh;
  Departures departures;
  Targets targets(mesh.vertex_slots(), interface_index);
  for (const TetId t : chosen.leaving)
    for (const VertexId v : mesh.vertices(t)) targets.note(v, chosen.to[t.value]);
  departures.staying.resize(mesh.vertex_slots());
  for_each_tet_at(mesh, targets.last(), [&](TetId t, const TetVertices& vertices) {
    if (chosen.leaves(t)) return;
    for (const VertexId v : vertices) {
      if (!targets.known(v)) continue;
      targets.note(v, order.self());
      departures.staying[v.value] = t;
    }
  });
  departures.vertices = targets.take_vertices();
  departures.is_of_interface = targets.take_several();
  for (const Targets::Found& found : targets.found())
    departures.of_interface.push_back(
        {s.global_id(VertexId(found.vertex)), order.subdomain(found.to), found.vertex});
  std::sort(departures.of_interface.begin(), departures.of_interface.end());
  departures.of_interface.erase(std::unique(departures.of_interface.begin(), departures.of_interface.end()),
                                departures.of_interface.end());
  return departures;
}

void remove_leaving(Subdomain& s, const Chosen& chosen, const Departures& departures) {
  TetMesh& mesh = *s.mesh;
  for (const TetId t : chosen.leaving) {
    for (int f = 0; f < 4; ++f)
      if (const TetFace n = mesh.neighbour(t, f); n.valid() && !chosen.leaves(n.tet()))
        mesh.set_neighbour(n.tet(), n.face(), TetFace());
    mesh.kill(t);
  }
  for (const std::uint32_t v : departures.vertices)
    mesh.set_tet_of(VertexId(v), departures.staying[v]);  // dead when invalid
  forget_features(mesh, departures.vertices);
  for (const std::uint32_t i : departures.vertices)
    if (const VertexId v(i); !mesh.alive(v)) {
      mesh.kill(v);
      mesh.thaw(v);
    }
}

}  // namespace weft::partition
