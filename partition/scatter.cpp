// Joining of parcels by global ids, and who holds which vertex afterwards.
#include <algorithm>
#include <unordered_map>

#include "partition/shift.h"

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::TetMesh;
using meshing::TetVertices;
using meshing::VertexId;

namespace {

using FaceName = std::array<std::uint32_t, 3>;
struct FaceNameHash {
  std::size_t operator()(const FaceName& f) const noexcept {
    std::uint64_t h = f[0];
    h = h * 0x9E3779B97F4A7C15ull + f[1];
    h = h * 0x9E3779B97F4A7C15ull + f[2];
    return h ^ h >> 29;
  }
};

/// Puts tets of parcels into the mesh.
class Joining {
 public:
  explicit Joining(Subdomain& s) : s_(s), mesh_(*s.mesh) {
    for (std::uint32_t i = 0; i < s.interface.size(); ++i)
      if (const VertexId v = s.interface.local(i); v.valid() && mesh_.alive(v))
        vertices_.emplace(s.interface.id(i), v);
  }

  /// After all parcels have been added the faces between them and with the mesh are joined.
  void add(const Parcel& parcel) {
    std::vector<VertexId> local;
    for (const Parcel::Vertex& v : parcel.vertices) local.push_back(vertex(v));
    const std::uint32_t first = mesh_.take_tet_slots(static_cast<std::uint32_t>(parcel.tets.size()));
    for (std::uint32_t k = 0; k < parcel.tets.size(); ++k) {
      const Parcel::Tet& t = parcel.tets[k];
      const TetId id(first + k);
      for (int i = 0; i < 4; ++i) {
        const VertexId v = local[t.vertices[i]];
        mesh_.set_vertex(id, i, v);
        const std::uint32_t n = t.neighbours[i];
        mesh_.set_neighbour(id, i, n == meshing::kNoNeighbour ? TetFace() : TetFace(4 * first + n));
        mesh_.set_patch(id, i, t.patches[i]);
        mesh_.set_tet_of(v, id);
      }
      mesh_.set_ref(id, t.ref);
      mesh_.set_quality(id, t.quality);
    }
    for (const Parcel::FeatureEdge& e : parcel.feature_edges)
      mesh_.set_curve(local[e.ends[0]], local[e.ends[1]], e.curve);
  }

  /// Every open face may be one that has its other side here now, unless a vertex of it was nobody else's.
  void join_faces() {
    known_.assign(mesh_.vertex_slots(), 0);
    for (const auto& [id, v] : vertices_) known_[v.value] = 1;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i) {
      if (!mesh_.alive(TetId(i))) continue;
      for (int f = 0; f < 4; ++f)
        if (!mesh_.neighbour(TetId(i), f).valid()) join(TetFace(TetId(i), f));
    }
  }

  const std::vector<VertexId>& arrived() const { return arrived_; }

 private:
  VertexId vertex(const Parcel::Vertex& v) {
    const auto [at, is_new] = vertices_.try_emplace(v.id);
    if (!is_new) return at->second;
    const VertexId x(mesh_.take_vertex_slots(1));
    arrived_.push_back(x);
    mesh_.set_point(x, v.point);
    mesh_.set_metric(x, v.log_metric, meshing::exp_fast(v.log_metric));
    mesh_.set_label(x, v.id.value());
    mesh_.set_kind(x, v.kind);
    mesh_.set_flags(x, v.flags);
    mesh_.set_ref(x, v.ref);
    mesh_.set_surface_hint(x, v.surface_hint);
    mesh_.set_background_hint(x, s_.background.tet_of(v.background));
    return at->second = x;
  }

  void join(TetFace face) {
    FaceName name;
    for (int i = 0; i < 3; ++i) {
      name[i] = mesh_.vertex(face.tet(), meshing::kTetFaces[face.face()][i]).value;
      if (!known_[name[i]]) return;
    }
    std::sort(name.begin(), name.end());
    const auto [at, is_new] = open_.try_emplace(name, face);
    if (is_new) return;
    mesh_.glue(face, at->second);
    open_.erase(at);
  }

  Subdomain& s_;
  TetMesh& mesh_;
  std::unordered_map<GlobalId, VertexId> vertices_;
  std::vector<VertexId> arrived_;
  std::unordered_map<FaceName, TetFace, FaceNameHash> open_;
  std::vector<std::uint8_t> known_;  ///< vertices of the interface or of parcels
};

bool by_vertex(const Holder& a, const Holder& b) { return a.vertex < b.vertex; }

/// Calls f(vertex, lines) for each vertex of sorted lines.
template <class F>
void for_each_vertex(std::span<const Holder> lines, F f) {
  for (std::size_t i = 0; i < lines.size();) {
    std::size_t end = i;
    while (end < lines.size() && lines[end].vertex == lines[i].vertex) ++end;
    f(lines[i].vertex, lines.subspan(i, end - i));
    i = end;
  }
}

/// All holders, this subdomain included, of the vertices of the old interface and of those that tets have
/// left.
class NewHolders {
 public:
  NewHolders(const Subdomain& s, std::span<const Parcel> parcels) : s_(s) {
    lines_ = s.departures;
    for (const Parcel& p : parcels) lines_.insert(lines_.end(), p.now.begin(), p.now.end());
    for (std::uint32_t i = 0; i < s.interface.size(); ++i) add_those_who_stayed(i, parcels);
    sort_unique(lines_);
  }

  std::span<const Holder> lines() const { return lines_; }
  std::span<const Holder> of(GlobalId vertex) const {
    const auto [first, last] = std::equal_range(lines_.begin(), lines_.end(), Holder{vertex, 0}, by_vertex);
    return {first, last};
  }

 private:
  /// A holder that says nothing of a vertex keeps all its tets around it.
  void add_those_who_stayed(std::uint32_t i, std::span<const Parcel> parcels) {
    const GlobalId id = s_.interface.id(i);
    const auto silent = [&](std::span<const Holder> lines) {
      return !std::binary_search(lines.begin(), lines.end(), Holder{id, 0}, by_vertex);
    };
    if (silent(s_.departures)) lines_.push_back({id, s_.id});
    for (const Holder& h : s_.interface.others(i)) {
      const auto at = std::lower_bound(parcels.begin(), parcels.end(), h.subdomain,
                                       [](const Parcel& p, SubdomainId other) { return p.from < other; });
      if (silent(at->now)) lines_.push_back(h);
    }
  }

  const Subdomain& s_;
  std::vector<Holder> lines_;
};

/// For vertices that this subdomain is the lowest to have held: those who hold them now and did not are told
/// of all holders.
std::vector<Scattered::Addressed> write_notices(const Subdomain& s, const NewHolders& now) {
  std::vector<std::pair<SubdomainId, Holder>> lines;
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
    if (s.interface.others(i).front().subdomain < s.id) continue;
    const auto holders = now.of(s.interface.id(i));
    for (const Holder& h : holders)
      if (h.subdomain != s.id && !s.interface.held_by(i, h.subdomain))
        for (const Holder& line : holders) lines.push_back({h.subdomain, line});
  }
  std::sort(lines.begin(), lines.end());
  std::vector<Scattered::Addressed> notices;
  for (const auto& [to, line] : lines) {
    if (notices.empty() || notices.back().to != to) notices.push_back({to, {}});
    notices.back().notice.holders.push_back(line);
  }
  return notices;
}

/// Who will tell this subdomain about vertices that it did not hold and several others did.
std::vector<SubdomainId> notices_expected(std::span<const Holder> before) {
  std::vector<SubdomainId> from;
  for_each_vertex(
      before, [&](GlobalId, std::span<const Holder> holders) { from.push_back(holders.front().subdomain); });
  std::sort(from.begin(), from.end());
  from.erase(std::unique(from.begin(), from.end()), from.end());
  return from;
}

/// Freezes the vertices of the new interface, which are among the frozen ones and those that have just
/// arrived; thaws what was frozen and is none of them, and returns that.
std::vector<VertexId> replace_interface(Subdomain& s, Interface interface,
                                        std::span<const VertexId> arrived) {
  std::vector<VertexId> thawed;
  TetMesh& mesh = *s.mesh;
  s.interface = std::move(interface);
  const auto settle = [&](VertexId v) {
    const std::uint32_t at = s.interface.find(s.global_id(v));
    if (at != Interface::kNone) {
      s.interface.set_local(at, v);
      mesh.freeze(v);
    } else if (mesh.frozen(v)) {
      mesh.thaw(v);
      mesh.set_flags(v, mesh.flags(v) | kWasInterface);
      thawed.push_back(v);
    }
  };
  for (const VertexId v : arrived) settle(v);
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.frozen(VertexId(i)) && mesh.alive(VertexId(i))) settle(VertexId(i));
  return thawed;
}

/// Tets around the given vertices become fresh: what lies beyond has been free where it was, and is looked at
/// when something beside it changes. (A layer more cost a seventh of all time and made nothing better.)
void freshen(TetMesh& mesh, std::span<const VertexId> vertices) {
  std::vector<std::uint8_t> thawed(mesh.vertex_slots(), 0);
  for (const VertexId v : vertices) thawed[v.value] = 1;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    const TetVertices v = mesh.vertices(t);
    if (thawed[v[0].value] | thawed[v[1].value] | thawed[v[2].value] | thawed[v[3].value])
      mesh.mark(t, meshing::kFresh);
  }
}

}  // namespace

Scattered scatter(Subdomain& s, std::span<Parcel> parcels) {
  Scattered result;
  const auto says_nothing = [](const Parcel& p) { return p.tets.empty() && p.now.empty(); };
  if (s.departures.empty() && std::all_of(parcels.begin(), parcels.end(), says_nothing)) return result;
  std::vector<std::shared_ptr<const BackgroundPiece>> pieces;
  for (Parcel& p : parcels)
    for (BackgroundPiece& piece : p.pieces)
      if (!s.background.has(piece.id))
        pieces.push_back(std::make_shared<const BackgroundPiece>(std::move(piece)));
  if (!pieces.empty()) s.background.add(pieces);
  Joining joining(s);
  for (const Parcel& p : parcels) {
    joining.add(p);
    result.received += p.tets.size();
  }
  if (result.received > 0) joining.join_faces();

  const NewHolders now(s, parcels);
  result.notices = write_notices(s, now);
  std::vector<Holder> before;
  for (const Parcel& p : parcels) before.insert(before.end(), p.before.begin(), p.before.end());
  sort_unique(before);
  result.expected = notices_expected(before);

  // Vertices of which the last word is not known yet keep those who held them before, and stay frozen.
  std::vector<Holder> lines;
  for_each_vertex(now.lines(), [&](GlobalId, std::span<const Holder> holders) {
    if (std::none_of(holders.begin(), holders.end(), [&](const Holder& h) { return h.subdomain == s.id; }))
      return;
    for (const Holder& h : holders)
      if (h.subdomain != s.id) lines.push_back(h);
  });
  lines.insert(lines.end(), before.begin(), before.end());
  const std::vector<VertexId> thawed = replace_interface(s, Interface(std::move(lines)), joining.arrived());
  s.departures.clear();
  result.thawed = thawed.size();
  if (result.thawed > 0) freshen(*s.mesh, thawed);
  return result;
}

std::uint64_t update_topology(Subdomain& s, std::span<const Notice> notices) {
  if (notices.empty()) return 0;
  std::vector<Holder> told;
  for (const Notice& n : notices) told.insert(told.end(), n.holders.begin(), n.holders.end());
  sort_unique(told);
  std::vector<Holder> lines;
  for (const Holder& line : s.interface.lines())
    if (!std::binary_search(told.begin(), told.end(), line, by_vertex)) lines.push_back(line);
  for (const Holder& line : told)
    if (line.subdomain != s.id) lines.push_back(line);
  const std::vector<VertexId> thawed = replace_interface(s, Interface(std::move(lines)), {});
  if (!thawed.empty()) freshen(*s.mesh, thawed);
  return thawed.size();
}

}  // namespace weft::partition
