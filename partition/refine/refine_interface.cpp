// Canonical bisection of interface edges.
#include "partition/refine/refine_interface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <queue>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "meshing/base/place_in.h"
#include "meshing/kernel/kernel.h"
#include "meshing/operators/split_edge.h"
#include "partition/refine/interface_faces.h"

namespace weft::partition {

using meshing::LogMetric;
using meshing::Point;
using meshing::TetFace;
using meshing::TetId;
using meshing::TetMesh;
using meshing::Vec;
using meshing::VertexId;
using meshing::VertexKind;

namespace {

using EdgeIndex = InterfaceFaces::EdgeIndex;
using VertexIndex = RefinedVertices::Index;

/// An edge to be split.
struct LongEdge {
  double length;
  GlobalId low, high;
  EdgeIndex edge;
};
struct ShorterFirst {
  bool operator()(const LongEdge& x, const LongEdge& y) const {
    if (x.length != y.length) return x.length < y.length;
    return std::pair(x.low, x.high) < std::pair(y.low, y.high);
  }
};

/// Where the vertices are at present, by index: all of them are frozen.
std::vector<VertexId> places_of(const RefinedVertices& vertices, const Subdomain& s) {
  std::vector<VertexId> places(vertices.size());
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i)
    if (const VertexId v(i); s.mesh->alive(v) && s.mesh->frozen(v))
      places.at(vertices.find(s.global_id(v))) = v;
  return places;
}

/// Whether is_so(vertices) is true of a face beyond which a neighbour has the tet; ends with the first.
template <class IsSo>
bool any_interface_face(const Subdomain& s, const Geometry& geometry, IsSo is_so) {
  const TetMesh& mesh = *s.mesh;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    for (int k = 0; k < 4; ++k) {
      if (mesh.neighbour(t, k).valid()) continue;
      const meshing::PatchId patch = mesh.patch(t, k);
      if (patch.valid() && !geometry.patch_inner[patch.value]) continue;
      std::array<VertexId, 3> v;
      for (std::size_t c = 0; c < 3; ++c) v[c] = mesh.vertex(t, meshing::kTetFaces[k][c]);
      if (is_so(v)) return true;
    }
  }
  return false;
}

/// Calls f(vertices, by id) for each of these faces.
template <class F>
void for_each_interface_face(const Subdomain& s, const Geometry& geometry, F f) {
  any_interface_face(s, geometry, [&](std::array<VertexId, 3> v) {
    std::ranges::sort(v, {}, [&](VertexId x) { return s.mesh->label(x); });
    f(v);
    return false;
  });
}

/// What neighbours compare of the interface's faces. Every vertex is in several of them: its bits are hashed
/// once.
class FaceDigests {
 public:
  explicit FaceDigests(const TetMesh& mesh) : mesh_(mesh), bits_(mesh.vertex_slots()) {
    for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
      if (const VertexId v(i); mesh.alive(v) && mesh.frozen(v)) bits_[i] = bits_of(v);
  }

  /// `v` by id.
  InterfaceVertices::Face of(const std::array<VertexId, 3>& v) const {
    const auto id = [&](std::size_t i) { return GlobalId::from_value(mesh_.label(v[i])); };
    const auto bits = [&](std::size_t i) { return bits_[v[i].value]; };
    return {of_three(id).value(), of_three(bits).value()};
  }

 private:
  template <class Part>
  static GlobalId of_three(const Part& part) {
    return GlobalId::derived_from(GlobalId::derived_from(part(0), part(1)), part(2));
  }

  GlobalId bits_of(VertexId v) const {
    const Point& p = mesh_.point(v);
    const LogMetric& l = mesh_.log_metric(v);
    GlobalId bits;
    for (const double x : {p.x, p.y, p.z, l.xx, l.xy, l.yy, l.xz, l.yz, l.zz})
      bits = GlobalId::derived_from(bits, GlobalId::from_value(std::bit_cast<std::uint64_t>(x)));
    return bits;
  }

  const TetMesh& mesh_;
  std::vector<GlobalId> bits_;  ///< of the frozen vertices, by slot
};

/// Derived names are hashes: two vertices may have the same, by an accident of 1 in 1e19 for each pair.
void check_names(const RefinedVertices& vertices, SubdomainId subdomain) {
  for (VertexIndex i = vertices.first_new() + 1; i < vertices.size(); ++i)
    if (vertices.id(i) == vertices.id(i - 1)) {
      std::ostringstream text;
      text << "subdomain " << subdomain.value << ": two new vertices of the interface have the global id "
           << vertices.id(i);
      throw std::runtime_error(text.str());
    }
}

/// All splits down to one length.
class Level {
 public:
  Level(const Subdomain& s, const Geometry& geometry, RefinedVertices& vertices, double longest,
        meshing::MetricMean mean)
      : vertices_(vertices),
        longest_(longest),
        mesh_(*s.mesh),
        surface_(geometry.surface.part(s.surface)),
        background_(s.background.background()),
        kernel_{mesh_, background_, surface_, {}, {.mean = mean}},
        worker_(kernel_, 1, true),
        faces_(mesh_, geometry.patch_inner),
        index_of_(mesh_.vertex_slots(), RefinedVertices::kNone),
        place_(places_of(vertices, s)) {
    for (VertexIndex i = 0; i < place_.size(); ++i) index_of_.at(place_[i].value) = i;
  }

  void run() {
    const VertexIndex known = vertices_.size();
    consider_edges_from(0);
    while (!long_edges_.empty()) {
      const EdgeIndex e = long_edges_.top().edge;
      long_edges_.pop();
      split(e);
    }
    for (VertexIndex i = known; i < vertices_.size(); ++i) mesh_.freeze(place_[i]);
    vertices_.sort_new();
  }

 private:
  /// a has the lower id.
  struct Edge {
    VertexId a, b;
  };

  VertexIndex index_of(VertexId v) const { return index_of_[v.value]; }
  GlobalId id(VertexId v) const { return GlobalId::from_value(mesh_.label(v)); }
  bool is_new(VertexId v) const { return index_of(v) >= vertices_.first_new(); }

  Edge edge(EdgeIndex e) const {
    const auto [a, b] = faces_.ends(e);
    return id(a) < id(b) ? Edge{a, b} : Edge{b, a};
  }

  void consider_edges_from(EdgeIndex first) {
    for (EdgeIndex e = first; e < faces_.num_edges(); ++e) {
      const auto [a, b] = edge(e);
      const double length = length_between(mesh_, a, b);
      if (length > longest_ && may_split(a, b)) long_edges_.push({length, id(a), id(b), e});
    }
  }

  bool may_split(VertexId a, VertexId b) const {
    return !must_stay(a, b) && !nears_what_stays(a, b) && !nears_what_stays(b, a);
  }

  bool must_stay(VertexId a, VertexId b) const {
    const int both = mesh_.flags(a) & mesh_.flags(b);
    if (both & (meshing::kOnCurved | meshing::kFixed)) return true;
    if ((mesh_.flags(a) | mesh_.flags(b)) & kDelicate) return true;
    const meshing::CurveId on = mesh_.curve(a, b);
    return on.valid() && surface_.curves()[on.value].required;
  }

  /// Where a long side (a, c) of a face (a, c, d) must stay, splitting what leads from `a` to new vertices of
  /// the face, and from c, would come nearer to that side without end. Whoever has such an edge has the face.
  bool nears_what_stays(VertexId a, VertexId b) const {
    constexpr double kClearlyShort = 0.75;  // beside such a side the splits do end, soon
    if (is_new(a) || !is_new(b)) return false;
    return std::ranges::any_of(vertices_.corners(index_of(b)), [&](VertexIndex corner) {
      if (corner == RefinedVertices::kNone) return false;
      const VertexId c = place_[corner];
      return c != a && must_stay(a, c) &&
             length_between(mesh_, a, c) > kClearlyShort * kernel_.limits.long_edge;
    });
  }

  meshing::VertexOnEdge place(const Edge& e) const {
    const Vec d = mesh_.point(e.b) - mesh_.point(e.a);
    const double share = meshing::metric_middle(std::sqrt(squared_length(mesh_.metric(e.a), d)),
                                                std::sqrt(squared_length(mesh_.metric(e.b), d)));
    meshing::VertexOnEdge at;
    at.x = mesh_.point(e.a) + share * d;
    at.log_metric = (1 - share) * mesh_.log_metric(e.a) + share * mesh_.log_metric(e.b);
    at.curve = mesh_.curve(e.a, e.b);
    at.background_hint = background_tet(at.x, e);
    return at;
  }

  /// The background has corners that stand in the way from one end more often than from both.
  std::uint32_t background_tet(const Point& x, const Edge& e) const {
    for (const VertexId v : {e.a, e.b})
      if (const auto end = background_.walk_towards(x, mesh_.background_hint(v)); end.reached) return end.tet;
    return background_.at(x, mesh_.background_hint(e.a)).tet;
  }

  /// Finds the tets around an edge, and one of each set of joined ones (every set has two of the faces, at
  /// its ends). Returns the patch that the edge lies in, as far as they tell.
  meshing::PatchId look_around(const Edge& e, EdgeIndex index) {
    meshing::PatchId patch;
    for (auto* list : {&at_edge_, &ends_seen_}) list->clear();
    for (auto* list : {&fans_, &tets_}) list->clear();
    faces_.append_faces(index, at_edge_);
    for (const TetFace face : at_edge_) {
      if (std::find(ends_seen_.begin(), ends_seen_.end(), face) != ends_seen_.end()) continue;
      if (gather_fan(face.tet(), e)) {
        take_fan(face.tet(), patch);
        continue;
      }
      for (const TetId t : cut_long_fan(face.tet(), e)) {
        gather_fan(t, e);
        take_fan(t, patch);
      }
    }
    return patch;
  }

  /// The tets that are joined with one around the edge; false where they are more than a shell can have.
  bool gather_fan(TetId t, const Edge& e) {
    worker_.claims.claim_tet(t);
    const auto verdict = gather_shell(mesh_, worker_.claims, t, e.a, e.b, worker_.shell);
    worker_.claims.release();
    return verdict == meshing::Verdict::accepted;
  }

  void take_fan(TetId t, meshing::PatchId& patch) {
    const meshing::Shell& shell = worker_.shell;
    fans_.push_back(t);
    for (int i = 0; i < shell.size; ++i) tets_.push_back(shell.tets[i].tet);
    ends_seen_.emplace_back(shell.tets[0].tet, shell.tets[0].s);
    ends_seen_.emplace_back(shell.tets[shell.size - 1].tet, shell.tets[shell.size - 1].r);
    if (const auto on = meshing::classify(mesh_, shell); on.patch.valid()) patch = on.patch;
  }

  /// An axis of an O-grid may have any number of tets around it. Their fan is taken apart, until the edge is
  /// split, into fans that a shell can have; returns a tet of each.
  std::vector<TetId> cut_long_fan(TetId start, const Edge& e) {
    meshing::Shell::Entry at = shell_entry(mesh_, start, e.a, e.b);
    for (TetFace n; (n = mesh_.neighbour(at.tet, at.s)).valid();) at = shell_entry(mesh_, n.tet(), e.a, e.b);
    std::vector<TetId> fans{at.tet};
    int size = 1;
    for (TetFace n; (n = mesh_.neighbour(at.tet, at.r)).valid(); ++size) {
      if (size == meshing::Shell::kMaxSize) {
        const TetFace face(at.tet, at.r);
        mesh_.set_neighbour(face.tet(), face.face(), TetFace());
        mesh_.set_neighbour(n.tet(), n.face(), TetFace());
        taken_apart_.push_back({face, n});
        fans.push_back(n.tet());
        size = 0;
      }
      at = shell_entry(mesh_, n.tet(), e.a, e.b);
    }
    return fans;
  }

  /// Both halves of each face where a fan was taken apart: those with the end that tets have kept are where
  /// the face was, the others in the tets' other halves, which have the same local places.
  void join_fans(VertexId kept) {
    const auto other_half = [&](TetFace f) {
      return TetFace(mesh_.neighbour(f.tet(), mesh_.local_index(f.tet(), kept)).tet(), f.face());
    };
    for (const auto& [a, b] : taken_apart_) {
      mesh_.glue(other_half(a), other_half(b));
      mesh_.glue(a, b);
    }
    taken_apart_.clear();
  }

  void classify(const Edge& e, meshing::PatchId patch, meshing::VertexOnEdge& at) const {
    const VertexKind near = mesh_.kind(e.a);
    if (at.curve.valid()) {
      at.kind = VertexKind::ridge;
      at.surface_hint = surface_.project_to_curve(at.curve, at.x, near, mesh_.surface_hint(e.a)).hint;
    } else if (patch.valid()) {
      at.kind = VertexKind::surface;
      at.surface_hint = surface_.project_to_patch(patch, at.x, near, mesh_.surface_hint(e.a)).hint;
    }
  }

  void split(EdgeIndex index) {
    const Edge e = edge(index);
    const meshing::PatchId patch = look_around(e, index);
    meshing::VertexOnEdge at = place(e);
    classify(e, patch, at);
    for (const TetId t : fans_) worker_.claims.claim_tet(t);
    VertexId m = split_edge_at(worker_, e.a, e.b, fans_, at);
    while (!m.valid() && mesh_.is_full() && mesh_.grow()) m = split_edge_at(worker_, e.a, e.b, fans_, at);
    worker_.claims.release();
    if (!m.valid() && mesh_.is_full()) throw meshing::NoAddressSpace();
    if (!m.valid()) throw std::runtime_error("an interface edge could not be split: a tet would be inverted");
    join_fans(e.a);
    remember(m, e);
    const EdgeIndex first = faces_.num_edges();
    faces_.split(index, e.a, m, tets_);
    consider_edges_from(first);
  }

  void remember(VertexId m, const Edge& e) {
    const VertexIndex i = vertices_.add_between(index_of(e.a), index_of(e.b));
    mesh_.set_label(m, vertices_.id(i).value());
    if (m.value >= index_of_.size()) index_of_.resize(mesh_.vertex_slots(), RefinedVertices::kNone);
    index_of_[m.value] = i;
    place_.push_back(m);
  }

  RefinedVertices& vertices_;
  const double longest_;
  TetMesh& mesh_;
  meshing::Surface surface_;
  const meshing::Background& background_;
  meshing::Kernel kernel_;
  meshing::Worker worker_;
  InterfaceFaces faces_;
  std::vector<VertexIndex> index_of_;  ///< by slot
  std::vector<VertexId> place_;        ///< by index
  std::priority_queue<LongEdge, std::vector<LongEdge>, ShorterFirst> long_edges_;
  std::vector<TetFace> at_edge_, ends_seen_;  ///< these and the next: look_around()
  std::vector<TetId> fans_, tets_;
  std::vector<std::array<TetFace, 2>> taken_apart_;  ///< faces of the mesh: cut_long_fan()
};

/// Whether an edge of the interface's faces may be longer: what rounding might decide is.
bool may_have_longer_edge(const Subdomain& s, const Geometry& geometry, double longest) {
  constexpr double kSurely = 1 - 1e-9;  // a length lies between those by the metrics of both ends
  const double most = kSurely * longest * longest;
  const TetMesh& mesh = *s.mesh;
  const auto may_be_longer = [&](VertexId a, VertexId b) {
    const Vec d = mesh.point(b) - mesh.point(a);
    return !(squared_length(mesh.metric(a), d) <= most && squared_length(mesh.metric(b), d) <= most);
  };
  return any_interface_face(s, geometry, [&](const std::array<VertexId, 3>& v) {
    return may_be_longer(v[0], v[1]) || may_be_longer(v[1], v[2]) || may_be_longer(v[2], v[0]);
  });
}

}  // namespace

bool is_delicate(const std::array<Point, 4>& p) {
  // Halving edges some eight times leaves heights of a 256th; a point is off its edge by 1e-16 of its
  // coordinates.
  constexpr double kSafe = 1e-11;
  double size = 0, largest_area = 0;
  for (const Point& x : p)
    for (int k = 0; k < 3; ++k) size = std::max(size, std::abs(x[k]));
  for (const auto& f : meshing::kTetFaces)
    largest_area = std::max(largest_area, norm(cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]])));
  const double six_volume = dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0]));
  return !(six_volume > kSafe * size * largest_area);
}

InterfaceRefinement::InterfaceRefinement(Subdomain& s, const Geometry& geometry)
    : subdomain_(s), geometry_(geometry), vertices_(s.interface, s.phase) {}

void InterfaceRefinement::refine(double longest, meshing::MetricMean mean) {
  if (!may_have_longer_edge(subdomain_, geometry_, longest)) return;  // as where a mesh is adapted again
  Level(subdomain_, geometry_, vertices_, longest, mean).run();
}

std::vector<InterfaceVertices> InterfaceRefinement::created() const {
  const TetMesh& mesh = *subdomain_.mesh;
  check_names(vertices_, subdomain_.id);
  const std::vector<VertexId> places = places_of(vertices_, subdomain_);
  const auto neighbours = subdomain_.interface.neighbours();
  std::vector<InterfaceVertices> result(neighbours.size());
  for (VertexIndex i = vertices_.first_new(); i < vertices_.size(); ++i)
    for (const SubdomainId other : vertices_.holders(i)) {
      const std::size_t at = meshing::place_in(neighbours, other);
      result[at].vertices.push_back({vertices_.id(i), mesh.surface_hint(places[i]), mesh.kind(places[i])});
    }
  add_faces(result);
  return result;
}

/// To each neighbour that holds all three vertices: one of them has the tet beyond.
void InterfaceRefinement::add_faces(std::vector<InterfaceVertices>& result) const {
  std::vector<VertexIndex> index_of(subdomain_.mesh->vertex_slots(), RefinedVertices::kNone);
  const std::vector<VertexId> places = places_of(vertices_, subdomain_);
  for (VertexIndex i = 0; i < places.size(); ++i) index_of[places[i].value] = i;
  const auto neighbours = subdomain_.interface.neighbours();
  const FaceDigests digests(*subdomain_.mesh);
  for_each_interface_face(subdomain_, geometry_, [&](const std::array<VertexId, 3>& v) {
    const InterfaceVertices::Face face = digests.of(v);
    for (const SubdomainId other : vertices_.holders(index_of[v[0].value])) {
      const auto holds = [&](VertexId x) {
        return std::ranges::binary_search(vertices_.holders(index_of[x.value]), other);
      };
      if (!holds(v[1]) || !holds(v[2])) continue;
      const std::size_t at = meshing::place_in(neighbours, other);
      result[at].faces.push_back(face);
    }
  });
}

namespace {

/// The mesh is wrong, whatever the reason: better none.
[[noreturn]] void refuse(const Subdomain& s, const std::array<VertexId, 3>& v, const std::string& what) {
  std::ostringstream text;
  text
      << "subdomain " << s.id.value << ": interface face (" << s.global_id(v[0]) << ' ' << s.global_id(v[1])
      << ' ' << s.global_id(v[2]) << ") " << what
      << "; holders of an interface decide alike only with the same program, C library and kind of processor "
         "on all ranks";
  throw std::runtime_error(text.str());
}

/// What neighbours have sent, by name: a hash that is never 0.
class TheirFaces {
 public:
  using Face = InterfaceVertices::Face;

  explicit TheirFaces(std::span<const InterfaceVertices> theirs) {
    std::size_t faces = 0;
    for (const InterfaceVertices& of_one : theirs) faces += of_one.faces.size();
    slots_.resize(std::bit_ceil(2 * faces + 1), Face{0, 0});
    for (const InterfaceVertices& of_one : theirs)
      for (const Face& face : of_one.faces) {
        std::size_t at = face.name & mask();
        while (slots_[at].name != 0) at = (at + 1) & mask();
        slots_[at] = face;
      }
  }

  /// Whether `is_it` holds for one with the name.
  template <class IsIt>
  bool has(std::uint64_t name, const IsIt& is_it) const {
    for (std::size_t at = name & mask(); slots_[at].name != 0; at = (at + 1) & mask())
      if (slots_[at].name == name && is_it(slots_[at])) return true;
    return false;
  }

 private:
  std::size_t mask() const { return slots_.size() - 1; }

  std::vector<Face> slots_;
};

/// Each face of the interface is there, with the same bits, in a neighbour.
void compare_faces(const Subdomain& s, const Geometry& geometry, std::span<const InterfaceVertices> theirs) {
  using Face = InterfaceVertices::Face;
  const TheirFaces all(theirs);
  const FaceDigests digests(*s.mesh);
  for_each_interface_face(s, geometry, [&](const std::array<VertexId, 3>& v) {
    const Face mine = digests.of(v);
    if (all.has(mine.name, [&](const Face& face) { return face == mine; })) return;
    const bool named = all.has(mine.name, [](const Face&) { return true; });
    refuse(s, v, named ? "has other coordinates or metrics in a neighbour" : "is in no neighbour");
  });
}

}  // namespace

void register_interface(Subdomain& s, const Geometry& geometry, std::span<const InterfaceVertices> theirs) {
  compare_faces(s, geometry, theirs);
  std::unordered_map<GlobalId, VertexId> mine;
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i)
    if (s.mesh->alive(VertexId(i)) && s.mesh->frozen(VertexId(i)) && s.global_id(VertexId(i)).derived())
      mine.emplace(s.global_id(VertexId(i)), VertexId(i));
  std::vector<Holder> more;
  const auto neighbours = s.interface.neighbours();
  for (std::size_t n = 0; n < theirs.size(); ++n)
    for (const InterfaceVertices::Vertex& v : theirs[n].vertices) {
      const auto at = mine.find(v.id);
      if (at == mine.end()) continue;
      more.push_back({v.id, neighbours[n]});
      // Who has the boundary's faces at an edge knows best how it lies in the boundary.
      if (v.kind <= s.mesh->kind(at->second)) continue;
      s.mesh->set_kind(at->second, v.kind);
      s.mesh->set_surface_hint(at->second, v.surface_hint);
    }
  if (!more.empty()) {
    more.insert(more.end(), s.interface.lines().begin(), s.interface.lines().end());
    s.interface = Interface(std::move(more));
  }
  locate_interface(s);
}

}  // namespace weft::partition
