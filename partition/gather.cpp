// Proposals, and the choice and packing of the tets that leave.
#include <algorithm>
#include <unordered_set>

#include "meshing/quality.h"
#include "partition/shift.h"

namespace weft::partition {

using meshing::PatchId;
using meshing::TetFace;
using meshing::TetId;
using meshing::TetMesh;
using meshing::TetVertices;
using meshing::VertexId;
using meshing::VertexKind;

namespace {

/// Subdomains by their place in the order of priorities, 1 and up; 0 stands for nobody.
using Rank = std::uint32_t;
constexpr Rank kNobody = 0;

/// Chooses for each tet the subdomain that it goes to.
class Choice {
 public:
  Choice(const Subdomain& s, const Priority& mine, std::span<const Proposal> proposals)
      : s_(s), mesh_(*s.mesh) {
    order_.push_back(mine);
    for (const Proposal& p : proposals) order_.push_back(p.priority);
    std::sort(order_.begin(), order_.end());
    const auto place = [&](SubdomainId id) {
      const auto at =
          std::find_if(order_.begin(), order_.end(), [&](const Priority& p) { return p.id == id; });
      return static_cast<Rank>(at - order_.begin()) + 1;
    };
    self_ = place(s.id);
    for (const SubdomainId neighbour : s.interface.neighbours())
      rank_of_neighbour_.push_back(place(neighbour));
  }

  Rank self() const { return self_; }
  SubdomainId subdomain(Rank r) const { return order_[r - 1].id; }
  std::size_t ranks() const { return order_.size() + 1; }

  /// The ranks of the tets' new subdomains, by slot (dead ones too).
  std::vector<Rank> choose(std::span<const GlobalId> wanted, std::span<const Proposal> proposals,
                           const ShiftOptions& options) {
    vertex_.assign(mesh_.vertex_slots(), kNobody);
    tet_.assign(mesh_.tet_slots(), kNobody);
    seed(wanted);
    for (const Proposal& p : proposals) seed(p.wants);
    take_at_vertices();
    for (int layer = 0; layer < options.layers && !taken_.empty(); ++layer) {
      if (options.by_faces) {
        take_across_faces();
      } else {
        spread_to_vertices();
        take_at_vertices();
      }
    }
    for (Rank& r : tet_)
      if (r == kNobody) r = self_;
    return std::move(tet_);
  }

 private:
  Rank rank_of(SubdomainId id) const {
    const auto neighbours = s_.interface.neighbours();
    return rank_of_neighbour_[static_cast<std::size_t>(
        std::lower_bound(neighbours.begin(), neighbours.end(), id) - neighbours.begin())];
  }

  /// Wanted vertices belong to the first of their holders.
  void seed(std::span<const GlobalId> wanted) {
    std::uint32_t i = 0;
    for (const GlobalId id : wanted) {  // both are sorted
      while (s_.interface.id(i) < id) ++i;
      Rank first = self_;
      for (const Holder& h : s_.interface.others(i)) first = std::max(first, rank_of(h.subdomain));
      vertex_[s_.interface.local(i).value] = first;
    }
  }

  /// Every tet that has no subdomain yet takes the first among its vertices'.
  void take_at_vertices() {
    taken_.clear();
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i) {
      if (tet_[i] != kNobody || !mesh_.alive(TetId(i))) continue;
      Rank first = kNobody;
      for (const VertexId v : mesh_.vertices(TetId(i))) first = std::max(first, vertex_[v.value]);
      if (first == kNobody) continue;
      tet_[i] = first;
      taken_.push_back(i);
    }
  }

  /// Vertices without a subdomain take the first among the tets that were taken last.
  void spread_to_vertices() {
    next_.clear();
    for (const std::uint32_t i : taken_)
      for (const VertexId v : mesh_.vertices(TetId(i)))
        if (vertex_[v.value] == kNobody) next_.push_back({v.value, tet_[i]});
    for (const auto& [v, r] : next_) vertex_[v] = std::max(vertex_[v], r);
  }

  /// The same from tet to tet through faces.
  void take_across_faces() {
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

  const Subdomain& s_;
  const TetMesh& mesh_;
  std::vector<Priority> order_;
  Rank self_ = kNobody;
  std::vector<Rank> rank_of_neighbour_;
  std::vector<Rank> vertex_, tet_;
  std::vector<std::uint32_t> taken_;
  std::vector<std::pair<std::uint32_t, Rank>> next_;
};

/// Index in the interface of each vertex by slot, kNone for others.
std::vector<std::uint32_t> interface_index(const Subdomain& s) {
  std::vector<std::uint32_t> index(s.mesh->vertex_slots(), Interface::kNone);
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) index[s.interface.local(i).value] = i;
  return index;
}

/// A vertex with a subdomain that tets around it go to (or stay in).
struct Departure {
  std::uint32_t vertex;
  Rank to;
  friend auto operator<=>(const Departure&, const Departure&) = default;
};

/// Where the tets around each vertex go, for vertices of the interface around which not all stay and for
/// those that become vertices of it. A vertex that leaves with all its tets for one other concerns nobody
/// else. Of the tets that stay only those at vertices of departing ones are looked at twice.
std::vector<Departure> find_departures(const Subdomain& s, const std::vector<Rank>& rank, Rank self,
                                       const std::vector<std::uint32_t>& interface_index) {
  const TetMesh& mesh = *s.mesh;
  std::vector<Departure> all;
  std::vector<Rank> last(mesh.vertex_slots(), kNobody);  // neighbours in the arrays mostly go the same way
  const auto note = [&](VertexId v, Rank to) {
    if (last[v.value] != to) all.push_back({v.value, to});
    last[v.value] = to;
  };
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (rank[i] != self && mesh.alive(TetId(i)))
      for (const VertexId v : mesh.vertices(TetId(i))) note(v, rank[i]);
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (rank[i] == self && mesh.alive(TetId(i)))
      for (const VertexId v : mesh.vertices(TetId(i)))
        if (last[v.value] != kNobody) note(v, self);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  const auto alone = [&](std::size_t i) {
    return (i == 0 || all[i - 1].vertex != all[i].vertex) &&
           (i + 1 == all.size() || all[i + 1].vertex != all[i].vertex);
  };
  std::vector<Departure> found;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!alone(i) || interface_index[all[i].vertex] != Interface::kNone) found.push_back(all[i]);
  return found;
}

/// Packs the parcel for one neighbour.
class Packing {
 public:
  Packing(const Subdomain& s, SubdomainId to, const std::vector<std::uint32_t>& interface_index,
          std::vector<std::uint32_t>& place_of_tet)
      : s_(s), mesh_(*s.mesh), to_(to), interface_index_(interface_index), place_of_tet_(place_of_tet) {
    parcel_.from = s.id;
  }

  void add(TetId t) {
    if (places_.empty()) places_.assign(mesh_.vertex_slots(), kNoPlace);
    Parcel::Tet packed;
    const TetVertices v = mesh_.vertices(t);
    for (int i = 0; i < 4; ++i) {
      packed.vertices[i] = place_of(v[i]);
      packed.patches[i] = mesh_.patch(t, i);
    }
    packed.ref = mesh_.ref(t);
    packed.quality = mesh_.quality(t);
    place_of_tet_[t.value] = static_cast<std::uint32_t>(parcel_.tets.size());
    parcel_.tets.push_back(packed);
    tets_.push_back(t);
    add_features(v);
    add_background(v);
  }

  Parcel finish(const std::vector<Rank>& rank, const std::vector<Departure>& departures,
                const Choice& choice) {
    for (std::size_t i = 0; i < tets_.size(); ++i)
      for (int f = 0; f < 4; ++f) {
        const TetFace n = mesh_.neighbour(tets_[i], f);
        parcel_.tets[i].neighbours[f] =
            n.valid() && rank[n.tet().value] == rank[tets_[i].value]
                ? 4 * place_of_tet_[n.tet().value] + static_cast<std::uint32_t>(n.face())
                : meshing::kNoNeighbour;
      }
    for (const Departure& d : departures)
      if (concerns_receiver(d.vertex))
        parcel_.now.push_back({s_.global_id(VertexId(d.vertex)), choice.subdomain(d.to)});
    sort_unique(parcel_.now);
    for (const std::uint32_t v : vertices_) add_previous_holders(v);
    std::sort(pieces_.begin(), pieces_.end());
    pieces_.erase(std::unique(pieces_.begin(), pieces_.end()), pieces_.end());
    for (const auto& piece : s_.background.pieces(pieces_)) parcel_.pieces.push_back(*piece);
    return std::move(parcel_);
  }

 private:
  static constexpr std::uint32_t kNoPlace = 0xFFFFFFFFu;

  std::uint32_t place_of(VertexId v) {
    std::uint32_t& place = places_[v.value];
    if (place != kNoPlace) return place;
    place = static_cast<std::uint32_t>(parcel_.vertices.size());
    const BackgroundTet background = s_.background.name_of(mesh_.background_hint(v));
    if (pieces_.empty() || pieces_.back() != background.piece) pieces_.push_back(background.piece);
    vertices_.push_back(v.value);
    parcel_.vertices.push_back({s_.global_id(v), mesh_.point(v), mesh_.log_metric(v), background,
                                mesh_.surface_hint(v), mesh_.ref(v), mesh_.kind(v),
                                static_cast<std::uint8_t>(mesh_.flags(v) & ~meshing::kFrozen)});
    return place;
  }

  void add_features(const TetVertices& v) {
    for (const auto& e : meshing::kTetEdges) {
      const VertexId a = v[e[0]], b = v[e[1]];
      if (mesh_.kind(a) < VertexKind::ridge || mesh_.kind(b) < VertexKind::ridge) continue;
      const meshing::CurveId curve = mesh_.curve(a, b);
      if (!curve.valid()) continue;
      const std::uint64_t key = std::uint64_t{std::min(a, b).value} << 32 | std::max(a, b).value;
      if (features_.insert(key).second) parcel_.feature_edges.push_back({{place_of(a), place_of(b)}, curve});
    }
  }

  /// A tet that is larger than the pieces may cover one that none of its vertices is in.
  void add_background(const TetVertices& v) {
    std::array<std::uint64_t, 4> piece;
    for (int i = 0; i < 4; ++i) piece[i] = parcel_.vertices[places_[v[i].value]].background.piece;
    const auto differs =
        std::find_if(piece.begin(), piece.end(), [&](std::uint64_t p) { return p != piece[0]; });
    if (differs == piece.end()) return;
    const std::uint64_t other = *differs;
    meshing::Point centre;
    for (const VertexId x : v) centre += 0.25 * mesh_.point(x);
    look_up(centre, v[0]);
    if (std::count(piece.begin(), piece.end(), piece[0]) + std::count(piece.begin(), piece.end(), other) == 4)
      return;
    for (const auto& e : meshing::kTetEdges)
      if (piece[e[0]] != piece[e[1]]) look_up(midpoint(mesh_.point(v[e[0]]), mesh_.point(v[e[1]])), v[e[0]]);
  }
  void look_up(const meshing::Point& p, VertexId near) {
    const auto place = s_.background.background().locate(p, mesh_.background_hint(near));
    pieces_.push_back(s_.background.name_of(place.tet).piece);
  }

  bool concerns_receiver(std::uint32_t vertex) const {
    if (!places_.empty() && places_[vertex] != kNoPlace) return true;
    const std::uint32_t i = interface_index_[vertex];
    return i != Interface::kNone && s_.interface.held_by(i, to_);
  }

  void add_previous_holders(std::uint32_t vertex) {
    const std::uint32_t i = interface_index_[vertex];
    if (i == Interface::kNone || s_.interface.held_by(i, to_)) return;
    parcel_.before.push_back({s_.interface.id(i), s_.id});
    for (const Holder& h : s_.interface.others(i)) parcel_.before.push_back(h);
  }

  const Subdomain& s_;
  const TetMesh& mesh_;
  SubdomainId to_;
  const std::vector<std::uint32_t>& interface_index_;
  std::vector<std::uint32_t>& place_of_tet_;  ///< by slot; each tet is in one parcel
  Parcel parcel_;
  std::vector<TetId> tets_;              ///< of the parcel
  std::vector<std::uint32_t> vertices_;  ///< of the parcel
  std::vector<std::uint32_t> places_;    ///< vertex -> its place in the parcel; empty while that is
  std::unordered_set<std::uint64_t> features_;
  std::vector<std::uint64_t> pieces_;
};

/// Feature edges that no tet has any more are forgotten: vertices' places are used again.
void forget_features(TetMesh& mesh) {
  std::vector<TetMesh::FeatureEdge> features = mesh.feature_edges();
  if (features.empty()) return;
  std::unordered_set<std::uint64_t> present;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    if (!mesh.alive(TetId(i))) continue;
    const TetVertices v = mesh.vertices(TetId(i));
    for (const auto& e : meshing::kTetEdges) {
      const auto [a, b] = std::minmax(v[e[0]], v[e[1]]);
      if (mesh.kind(a) >= VertexKind::ridge && mesh.kind(b) >= VertexKind::ridge)
        present.insert(std::uint64_t{a.value} << 32 | b.value);
    }
  }
  for (const TetMesh::FeatureEdge& e : features) {
    const auto [a, b] = std::minmax(e.a, e.b);
    if (!present.contains(std::uint64_t{a.value} << 32 | b.value)) mesh.set_curve(a, b, meshing::CurveId());
  }
}

/// Removes the tets that do not stay, and the vertices that have none left.
void remove_departed(Subdomain& s, const std::vector<Rank>& rank, Rank self) {
  TetMesh& mesh = *s.mesh;
  const auto departs = [&](TetId t) { return rank[t.value] != self; };
  std::vector<std::uint8_t> bereft(mesh.vertex_slots(), 0);
  for (std::uint32_t i = 0; i < rank.size(); ++i) {
    const TetId t(i);
    if (!departs(t) || !mesh.alive(t)) continue;
    for (int f = 0; f < 4; ++f) {
      const VertexId v = mesh.vertex(t, f);
      bereft[v.value] = 1;
      mesh.set_tet_of(v, TetId());
      if (const TetFace n = mesh.neighbour(t, f); n.valid() && !departs(n.tet()))
        mesh.set_neighbour(n.tet(), n.face(), TetFace());
    }
    mesh.kill(t);
  }
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (mesh.alive(TetId(i)))
      for (const VertexId v : mesh.vertices(TetId(i)))
        if (bereft[v.value]) mesh.set_tet_of(v, TetId(i));
  forget_features(mesh);
  for (std::uint32_t i = 0; i < bereft.size(); ++i)
    if (const VertexId v(i); bereft[i] && !mesh.alive(v)) {
      mesh.kill(v);
      mesh.thaw(v);
    }
}

bool never_free(const TetMesh& mesh, VertexId v) { return !(mesh.flags(v) & kHasBeenFree); }

/// Frozen vertices of poor tets, by slot.
std::vector<std::uint8_t> at_poor_tets(const TetMesh& mesh) {
  constexpr float kPoor = 0.45f;
  std::vector<std::uint8_t> poor(mesh.vertex_slots(), 0);
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (mesh.quality(TetId(i)) < kPoor && mesh.alive(TetId(i)))
      for (const VertexId v : mesh.vertices(TetId(i))) poor[v.value] = mesh.frozen(v);
  return poor;
}

}  // namespace

std::vector<GlobalId> wanted(const Subdomain& s, std::uint64_t round) {
  std::vector<std::uint8_t> poor(s.mesh->vertex_slots(), 0);
  if (round < kRoundsForQuality) poor = at_poor_tets(*s.mesh);
  std::vector<GlobalId> ids;
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
    const VertexId v = s.interface.local(i);
    if (never_free(*s.mesh, v) || poor[v.value]) ids.push_back(s.interface.id(i));
  }
  return ids;
}

std::vector<Proposal> propose(const Subdomain& s, const Priority& mine, std::span<const GlobalId> wanted) {
  const auto neighbours = s.interface.neighbours();
  std::vector<Proposal> proposals(neighbours.size(), Proposal{mine, {}});
  std::uint32_t i = 0;
  for (const GlobalId id : wanted) {
    while (s.interface.id(i) < id) ++i;
    for (const Holder& h : s.interface.others(i))
      proposals[static_cast<std::size_t>(std::lower_bound(neighbours.begin(), neighbours.end(), h.subdomain) -
                                         neighbours.begin())]
          .wants.push_back(id);
  }
  return proposals;
}

std::vector<Parcel> gather(Subdomain& s, const Priority& mine, std::span<const GlobalId> wanted,
                           std::span<const Proposal> proposals, const ShiftOptions& options) {
  const auto wants_nothing = [](const Proposal& p) { return p.wants.empty(); };
  if (wanted.empty() && std::all_of(proposals.begin(), proposals.end(), wants_nothing)) {
    std::vector<Parcel> none(proposals.size());
    for (Parcel& p : none) p.from = s.id;
    return none;
  }
  Choice choice(s, mine, proposals);
  const std::vector<Rank> rank = choice.choose(wanted, proposals, options);
  const std::vector<std::uint32_t> index = interface_index(s);
  const std::vector<Departure> departures = find_departures(s, rank, choice.self(), index);
  std::vector<std::uint32_t> place_of_tet(rank.size());
  std::vector<Packing> packing;
  std::vector<std::size_t> packing_of(choice.ranks(), 0);
  const auto neighbours = s.interface.neighbours();
  packing.reserve(neighbours.size());
  for (const SubdomainId neighbour : neighbours) packing.emplace_back(s, neighbour, index, place_of_tet);
  for (Rank r = 1; r < choice.ranks(); ++r)
    packing_of[r] = static_cast<std::size_t>(
        std::lower_bound(neighbours.begin(), neighbours.end(), choice.subdomain(r)) - neighbours.begin());
  for (std::uint32_t i = 0; i < rank.size(); ++i)
    if (rank[i] != choice.self() && s.mesh->alive(TetId(i))) packing[packing_of[rank[i]]].add(TetId(i));
  std::vector<Parcel> parcels;
  for (Packing& p : packing) parcels.push_back(p.finish(rank, departures, choice));
  s.departures.clear();
  for (const Departure& d : departures) {
    s.departures.push_back({s.global_id(VertexId(d.vertex)), choice.subdomain(d.to)});
    s.mesh->freeze(VertexId(d.vertex));
  }
  sort_unique(s.departures);
  remove_departed(s, rank, choice.self());
  return parcels;
}

}  // namespace weft::partition
