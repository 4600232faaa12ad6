// Joining of parcels by global ids, and the holders of vertices afterwards.
#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "meshing/kernel/quality.h"
#include "meshing/metric/expectations.h"
#include "partition/shift/shift.h"
#include "partition/subdomain/adapt_subdomain.h"
#include "partition/subdomain/background_cover.h"
#include "partition/subdomain/surface_cover.h"
#include "partition/subdomain/tets_at.h"

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::TetMesh;
using meshing::TetVertices;
using meshing::VertexId;

namespace {

/// Finds vertices in an interface, as Interface::find, when they are asked for in ascending order.
class AscendingFinder {
 public:
  explicit AscendingFinder(const Interface& interface) : interface_(interface) {}

  std::uint32_t find(GlobalId id) {
    while (at_ < interface_.size() && interface_.id(at_) < id) ++at_;
    return at_ < interface_.size() && interface_.id(at_) == id ? at_ : Interface::kNone;
  }

 private:
  const Interface& interface_;
  std::uint32_t at_ = 0;
};

/// Puts the tets of parcels into the mesh.
class Joining {
 public:
  explicit Joining(Subdomain& s) : s_(s), mesh_(*s.mesh) {}

  void add(std::span<const Parcel> parcels) {
    name_vertices(parcels);
    for (std::size_t p = 0; p < parcels.size(); ++p) add(parcels[p], names_[p]);
    join_faces();
  }

  /// The shared vertices that were not here before, ascending by id.
  std::vector<VertexId> arrived() const {
    std::vector<VertexId> vertices;
    for (const Named& n : named_)
      if (n.is_new) vertices.push_back(n.vertex);
    return vertices;
  }

 private:
  struct OpenFace {
    std::uint64_t first_two;  ///< of its vertices, in ascending order
    std::uint32_t third;
    TetFace face;
    friend bool operator<(const OpenFace& a, const OpenFace& b) {
      return std::tie(a.first_two, a.third) < std::tie(b.first_two, b.third);
    }
    friend bool operator==(const OpenFace& a, const OpenFace& b) {
      return a.first_two == b.first_two && a.third == b.third;
    }
  };

  /// Of shared vertices, equal ids get one number; the interface's have a vertex here already. Others come in
  /// one parcel and are nowhere else.
  void name_vertices(std::span<const Parcel> parcels) {
    struct Arriving {
      GlobalId id;
      std::uint32_t parcel, index;
    };
    std::vector<Arriving> all;
    names_.resize(parcels.size());
    for (std::uint32_t p = 0; p < parcels.size(); ++p) {
      names_[p].resize(parcels[p].vertices.size(), kNoName);
      for (std::uint32_t i = 0; i < names_[p].size(); ++i)
        if (parcels[p].vertices[i].shared) all.push_back({parcels[p].vertices[i].id, p, i});
    }
    std::sort(all.begin(), all.end(), [](const Arriving& a, const Arriving& b) { return a.id < b.id; });
    const auto point_of = [&](const Arriving& a) -> const meshing::Point& {
      return parcels[a.parcel].vertices[a.index].point;
    };
    AscendingFinder finder(s_.interface);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const GlobalId id = all[k].id;
      if (k == 0 || id != all[k - 1].id) {
        const std::uint32_t at = finder.find(id);
        const VertexId v = at != Interface::kNone ? s_.interface.local(at) : VertexId();
        const bool here = v.valid() && mesh_.alive(v);
        named_.push_back({here ? v : VertexId(), !here, here});
        if (here) check_same_place(id, mesh_.point(v), point_of(all[k]));
      } else {
        named_.back().met = true;
        check_same_place(id, point_of(all[k - 1]), point_of(all[k]));
      }
      names_[all[k].parcel][all[k].index] = static_cast<std::uint32_t>(named_.size()) - 1;
    }
  }

  /// Copies of a vertex never move apart; two vertices of one name are an accident of hashing.
  void check_same_place(GlobalId id, const meshing::Point& a, const meshing::Point& b) const {
    if (std::memcmp(&a, &b, sizeof a) == 0) return;
    std::ostringstream text;
    text << "subdomain " << s_.id.value << ": copies of vertex " << id << " differ in their coordinates";
    throw std::runtime_error(text.str());
  }

  void add(const Parcel& parcel, const std::vector<std::uint32_t>& names) {
    std::vector<VertexId> local;
    local.reserve(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == kNoName) {
        local.push_back(create(parcel.vertices[i]));
        continue;
      }
      VertexId& v = named_[names[i]].vertex;
      if (!v.valid()) v = create(parcel.vertices[i]);
      local.push_back(v);
    }
    const std::uint32_t first = mesh_.take_tet_slots(static_cast<std::uint32_t>(parcel.tets.size()));
    std::vector<TetId> tet_of(local.size());  // vertices lie further apart in memory
    for (std::uint32_t k = 0; k < parcel.tets.size(); ++k) {
      const Parcel::Tet& t = parcel.tets[k];
      const TetId id(first + k);
      for (int i = 0; i < 4; ++i) {
        mesh_.set_vertex(id, i, local[t.vertices[i]]);
        tet_of[t.vertices[i]] = id;
        const std::uint32_t n = t.neighbours[i];
        mesh_.set_neighbour(id, i, n == meshing::kNoNeighbour ? TetFace() : TetFace(4 * first + n));
        mesh_.set_patch(id, i, meshing::PatchId());
      }
      mesh_.set_ref(id, t.ref);
      mesh_.set_quality(id, t.quality);
    }
    for (const Parcel::BoundaryFace& b : parcel.boundary_faces)
      mesh_.set_patch(TetId(first + b.face / 4), static_cast<int>(b.face % 4), b.patch);
    for (std::size_t i = 0; i < local.size(); ++i) mesh_.set_tet_of(local[i], tet_of[i]);
    for (const Parcel::FeatureEdge& e : parcel.feature_edges)
      mesh_.set_curve(local[e.ends[0]], local[e.ends[1]], e.curve);
  }

  VertexId create(const Parcel::Vertex& v) {
    const VertexId x(mesh_.take_vertex_slots(1));
    mesh_.set_point(x, v.point);
    mesh_.set_metric(x, v.log_metric, meshing::exp_fast(v.log_metric));
    mesh_.set_label(x, v.id.value());
    mesh_.set_kind(x, v.kind);
    mesh_.set_flags(x, v.flags);
    mesh_.set_ref(x, v.ref);
    mesh_.set_surface_hint(x, v.surface_hint);
    mesh_.set_background_hint(x, s_.background.tet_of(v.background));
    return x;
  }

  /// An open face of a tet that has arrived may have its other side in another parcel, or here: if all its
  /// vertices have.
  void join_faces() {
    std::vector<std::uint8_t> met(mesh_.vertex_slots(), 0);
    for (const Named& n : named_) met[n.vertex.value] = n.met;
    std::vector<OpenFace> open;
    for_each_tet_at(mesh_, met,
                    [&](TetId t, const TetVertices& vertices) { add_open_faces(t, vertices, met, open); });
    std::sort(open.begin(), open.end());
    for (std::size_t i = 1; i < open.size(); ++i)
      if (open[i] == open[i - 1]) mesh_.glue(open[i].face, open[i - 1].face);
  }

  void add_open_faces(TetId t, const TetVertices& v, const std::vector<std::uint8_t>& met,
                      std::vector<OpenFace>& open) const {
    std::array<std::uint8_t, 4> is_met;
    for (std::size_t i = 0; i < 4; ++i) is_met[i] = met[v[i].value];
    if (is_met[0] + is_met[1] + is_met[2] + is_met[3] < 3) return;
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& corners = meshing::kTetFaces[f];
      if (!(is_met[corners[0]] && is_met[corners[1]] && is_met[corners[2]]) ||
          mesh_.neighbour(t, static_cast<int>(f)).valid())
        continue;
      std::array<std::uint32_t, 3> name;
      for (std::size_t i = 0; i < 3; ++i) name[i] = v[corners[i]].value;
      std::sort(name.begin(), name.end());
      open.push_back({std::uint64_t{name[0]} << 32 | name[1], name[2], TetFace(t, static_cast<int>(f))});
    }
  }

  static constexpr std::uint32_t kNoName = 0xFFFFFFFFu;

  Subdomain& s_;
  TetMesh& mesh_;
  std::vector<std::vector<std::uint32_t>> names_;  ///< [parcel][vertex]: a number, of shared ones
  struct Named {
    VertexId vertex;
    bool is_new;
    bool met;  ///< here already, or in several parcels
  };
  std::vector<Named> named_;  ///< by name; ids ascend
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

/// All holders, this subdomain included, of the vertices that a parcel or this subdomain's departures
/// mention; other vertices keep theirs.
class NewHolders {
 public:
  NewHolders(const Subdomain& s, std::span<const Parcel> parcels)
      : s_(s), mentioned_(s.interface.size(), 0), silent_(s.interface.lines().size(), 1) {
    std::vector<std::vector<Holder>> said{s.departures};
    mention(s.departures, s.id);
    for (const Parcel& p : parcels) {
      said.push_back(p.now);
      mention(p.now, p.from);
    }
    said.push_back(remaining_holders());
    lines_ = merge_unique(std::move(said));
  }

  std::span<const Holder> lines() const { return lines_; }
  /// Of a vertex of the interface.
  bool mentioned(std::uint32_t i) const { return mentioned_[i]; }
  std::span<const Holder> of(GlobalId vertex) const {
    const auto [first, last] =
        std::equal_range(lines_.begin(), lines_.end(), Holder{vertex, SubdomainId(0)}, by_vertex);
    return {first, last};
  }

 private:
  /// Notes of which vertices `from` says something.
  void mention(std::span<const Holder> lines, SubdomainId from) {
    AscendingFinder finder(s_.interface);
    for (const Holder& line : lines) {
      const std::uint32_t i = finder.find(line.vertex);
      if (i == Interface::kNone) continue;
      mentioned_[i] |= from == s_.id ? kBySelf : kByOthers;
      for (const Holder& h : s_.interface.others(i))
        if (h.subdomain == from) silent_[line_of(h)] = 0;
    }
  }

  std::size_t line_of(const Holder& of_interface) const {
    return static_cast<std::size_t>(&of_interface - s_.interface.lines().data());
  }

  /// A holder that says nothing of a vertex keeps all its tets around it.
  std::vector<Holder> remaining_holders() const {
    std::vector<Holder> stayed;
    for (std::uint32_t i = 0; i < s_.interface.size(); ++i) {
      if (!mentioned_[i]) continue;
      const GlobalId id = s_.interface.id(i);
      bool has_self = mentioned_[i] & kBySelf;
      const auto add_self = [&] {
        if (!std::exchange(has_self, true)) stayed.push_back({id, s_.id});
      };
      for (const Holder& h : s_.interface.others(i)) {
        if (s_.id < h.subdomain) add_self();
        if (silent_[line_of(h)]) stayed.push_back(h);
      }
      add_self();
    }
    return stayed;
  }

  static constexpr std::uint8_t kBySelf = 1, kByOthers = 2;
  const Subdomain& s_;
  std::vector<std::uint8_t> mentioned_;  ///< by place in the interface: by whom
  std::vector<std::uint8_t> silent_;     ///< by line of the interface: its holder says nothing
  std::vector<Holder> lines_;
};

/// For vertices that this subdomain is the lowest to have held: those who hold them now and did not are told
/// of all holders.
std::vector<Scattered::Addressed> write_notices(const Subdomain& s, const NewHolders& now) {
  std::vector<std::pair<SubdomainId, Holder>> lines;
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
    if (!now.mentioned(i) || s.interface.others(i).front().subdomain < s.id) continue;
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

/// Freezes the vertices of the new interface, which are among those of the old one, those that gathering has
/// frozen and those that have just arrived (ascending by id); thaws what was frozen and is none of them, and
/// returns that.
std::vector<VertexId> replace_interface(Subdomain& s, Interface interface,
                                        std::span<const VertexId> arrived) {
  std::vector<VertexId> thawed;
  TetMesh& mesh = *s.mesh;
  std::vector<std::uint8_t> settled(mesh.vertex_slots(), 0);
  const auto settle = [&](VertexId v, std::uint32_t at) {
    settled[v.value] = 1;
    if (at != Interface::kNone) {
      interface.set_local(at, v);
      mesh.freeze(v);
    } else if (mesh.frozen(v)) {
      mesh.thaw(v);
      mesh.set_flags(v, mesh.flags(v) | kWasInterface);
      thawed.push_back(v);
    }
  };
  AscendingFinder among_old(interface), among_arrived(interface);
  for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
    const VertexId v = s.interface.local(i);
    if (v.valid() && mesh.alive(v)) settle(v, among_old.find(s.interface.id(i)));
  }
  for (const VertexId v : arrived) settle(v, among_arrived.find(s.global_id(v)));
  for (const VertexId v : s.frozen_since)
    if (mesh.frozen(v) && !settled[v.value] && mesh.alive(v)) settle(v, interface.find(s.global_id(v)));
  s.interface = std::move(interface);
  return thawed;
}

/// A vertex made on an interface edge has the metric that the edge's ends give, since all holders have those
/// alike. Where edges were longer than the background's, or no edges of it, that is not what the background
/// says. Returns whether the metric is another one now.
bool read_metric_anew(Subdomain& s, VertexId v) {
  if (!s.global_id(v).derived()) return false;
  const meshing::Background::Sample there =
      s.background.background().at(s.mesh->point(v), s.mesh->background_hint(v));
  const meshing::LogMetric before = s.mesh->log_metric(v);
  s.mesh->set_metric(v, there.log_metric, meshing::exp_fast(there.log_metric));
  s.mesh->set_background_hint(v, there.tet);
  return std::memcmp(&before, &there.log_metric, sizeof before) != 0;
}

/// Tets around the given vertices become fresh where something may be wrong: around those that have never
/// been free or have another metric now, and all that are poor. What lies beyond has been free where it was,
/// and is looked at when something beside it changes. (A layer more cost a seventh of all time and made
/// nothing better.)
void freshen(Subdomain& s, std::span<const VertexId> vertices) {
  if (vertices.empty()) return;
  TetMesh& mesh = *s.mesh;
  const bool new_metrics = s.phase > 0 || s.background.of_another_mesh();
  constexpr std::uint8_t kAsBefore = 1, kNew = 2;
  std::vector<std::uint8_t> thawed(mesh.vertex_slots(), 0);
  for (const VertexId v : vertices) {
    const bool has_new_metric = new_metrics && read_metric_anew(s, v);
    thawed[v.value] = has_new_metric || !(mesh.flags(v) & kHasBeenFree) ? kNew : kAsBefore;
  }
  for_each_tet_at(mesh, thawed, [&](TetId t, const TetVertices& v) {
    const int at = thawed[v[0].value] | thawed[v[1].value] | thawed[v[2].value] | thawed[v[3].value];
    if ((at & kNew) == 0 && mesh.quality(t) >= static_cast<float>(meshing::kFair)) return;
    mesh.mark(t, meshing::kFresh);
    if (new_metrics)
      mesh.set_quality(t, static_cast<float>(judge_quality(meshing::MetricMean::arithmetic, mesh, v)));
  });
}

/// The lines of the new interface. Vertices of which the last word is not known yet keep those who held them
/// `before`, and stay frozen.
std::vector<Holder> new_lines(const Subdomain& s, const NewHolders& now, std::span<const Holder> before) {
  std::vector<Holder> changed;
  for_each_vertex(now.lines(), [&](GlobalId, std::span<const Holder> holders) {
    if (std::none_of(holders.begin(), holders.end(), [&](const Holder& h) { return h.subdomain == s.id; }))
      return;
    for (const Holder& h : holders)
      if (h.subdomain != s.id) changed.push_back(h);
  });
  std::vector<Holder> kept;
  for (std::uint32_t i = 0; i < s.interface.size(); ++i)
    if (!now.mentioned(i))
      kept.insert(kept.end(), s.interface.others(i).begin(), s.interface.others(i).end());
  return merge_unique({std::move(kept), {before.begin(), before.end()}, std::move(changed)});
}

}  // namespace

Scattered scatter(Subdomain& s, std::span<Parcel> parcels) {
  Scattered result;
  const auto says_nothing = [](const Parcel& p) { return p.tets.empty() && p.now.empty(); };
  if (s.departures.empty() && std::all_of(parcels.begin(), parcels.end(), says_nothing)) return result;
  std::vector<std::shared_ptr<const BackgroundPiece>> pieces;
  for (Parcel& p : parcels)
    for (auto& piece : p.pieces)
      if (!s.background.has(piece->id)) pieces.push_back(std::move(piece));
  if (!pieces.empty()) s.background.add(pieces);
  for (const Parcel& p : parcels) s.surface.add(p.surface);
  std::uint64_t arriving = 0;
  for (const Parcel& p : parcels) arriving += std::max(p.tets.size(), 2 * p.vertices.size());
  make_room(s, arriving);
  Joining joining(s);
  joining.add(parcels);
  for (const Parcel& p : parcels) result.received += p.tets.size();

  const NewHolders now(s, parcels);
  result.notices = write_notices(s, now);
  std::vector<Holder> before;
  for (const Parcel& p : parcels) before.insert(before.end(), p.before.begin(), p.before.end());
  sort_unique(before);
  result.expected = notices_expected(before);

  const std::vector<VertexId> thawed =
      replace_interface(s, Interface(new_lines(s, now, before)), joining.arrived());
  s.departures.clear();
  s.frozen_since.clear();
  result.thawed = thawed.size();
  freshen(s, thawed);
  drop_far_background(s);
  drop_far_surface(s);
  return result;
}

std::uint64_t update_topology(Subdomain& s, std::span<const Notice> notices) {
  if (notices.empty()) return 0;
  std::vector<std::vector<Holder>> lists;
  for (const Notice& n : notices) lists.push_back(n.holders);
  std::vector<Holder> told = merge_unique(std::move(lists));
  std::vector<Holder> kept;
  auto at = told.begin();
  for (const Holder& line : s.interface.lines()) {
    while (at != told.end() && by_vertex(*at, line)) ++at;
    if (at == told.end() || by_vertex(line, *at)) kept.push_back(line);
  }
  std::erase_if(told, [&](const Holder& line) { return line.subdomain == s.id; });
  const std::vector<VertexId> thawed =
      replace_interface(s, Interface(merge_unique({std::move(kept), std::move(told)})), {});
  freshen(s, thawed);
  return thawed.size();
}

}  // namespace weft::partition
