// Canonical bisection of interface edges.
#include "partition/refine_interface.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "meshing/kernel.h"
#include "meshing/split_edge.h"

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

struct Edge {
  VertexId a, b;  ///< a has the lower id
  double length;
  GlobalId low, high;
};
struct ShorterFirst {
  bool operator()(const Edge& x, const Edge& y) const {
    if (x.length != y.length) return x.length < y.length;
    return std::pair(x.low, x.high) < std::pair(y.low, y.high);
  }
};

using Origins = std::unordered_map<GlobalId, InterfaceRefinement::Origin>;

/// All splits down to one length.
class Level {
 public:
  Level(Subdomain& s, const Geometry& geometry, Origins& origins, double longest)
      : s_(s),
        origins_(origins),
        longest_(longest),
        mesh_(*s.mesh),
        geometry_(geometry),
        surface_(geometry.surface),
        kernel_{mesh_, s.background.background(), geometry.surface, {}},
        worker_(kernel_, 1, true) {}

  void run() {
    find_frozen();
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i)
      for (int f = 0; f < 4; ++f)
        if (const TetFace face(TetId(i), f); mesh_.alive(TetId(i)) && is_interface(face)) add_face(face);
    while (!long_edges_.empty()) {
      const Edge e = long_edges_.top();
      long_edges_.pop();
      split(e);
    }
    for (const VertexId v : created_) mesh_.freeze(v);
  }

 private:
  static std::uint64_t key(VertexId a, VertexId b) {
    return std::uint64_t{std::min(a, b).value} << 32 | std::max(a, b).value;
  }

  void find_frozen() {
    for (std::uint32_t i = 0; i < mesh_.vertex_slots(); ++i)
      if (const VertexId v(i); mesh_.alive(v) && mesh_.frozen(v)) frozen_.emplace(s_.global_id(v), v);
  }

  /// Somebody else has the tet on the other side.
  bool is_interface(TetFace face) const {
    if (mesh_.neighbour(face.tet(), face.face()).valid()) return false;
    const meshing::PatchId patch = mesh_.patch(face.tet(), face.face());
    return !patch.valid() || geometry_.patch_inner[patch.value];
  }

  void add_face(TetFace face) {
    for (int i = 0; i < 3; ++i) add_side(face, i);
  }

  void add_side(TetFace face, int side) {
    VertexId a = mesh_.vertex(face.tet(), meshing::kTetFaces[face.face()][side]);
    VertexId b = mesh_.vertex(face.tet(), meshing::kTetFaces[face.face()][(side + 1) % 3]);
    if (s_.global_id(b) < s_.global_id(a)) std::swap(a, b);
    auto& faces = faces_[key(a, b)];
    faces.push_back(face);
    if (faces.size() == 1) add_edge(a, b);
  }

  void add_edge(VertexId a, VertexId b) {
    const double length = length_between(mesh_, a, b);
    if (length > longest_ && may_split(a, b))
      long_edges_.push({a, b, length, s_.global_id(a), s_.global_id(b)});
  }

  bool may_split(VertexId a, VertexId b) const {
    return !must_stay(a, b) && !nears_what_stays(a, b) && !nears_what_stays(b, a);
  }

  bool must_stay(VertexId a, VertexId b) const {
    const int both = mesh_.flags(a) & mesh_.flags(b);
    if (both & (meshing::kOnCurved | meshing::kFixed)) return true;
    if ((mesh_.flags(a) | mesh_.flags(b)) & kDelicate) return true;
    const meshing::CurveId curve = mesh_.curve(a, b);
    return curve.valid() && surface_.curves()[curve.value].required;
  }

  /// Where a long side (a, c) of a face (a, c, d) must stay, splitting what leads from `a` to new vertices of
  /// the face, and from c, would come nearer to that side without end. Whoever has such an edge has the face.
  bool nears_what_stays(VertexId a, VertexId b) const {
    constexpr double kClearlyShort = 0.75;  // beside such a side the splits do end, soon
    const auto inside = origins_.find(s_.global_id(b));
    if (origins_.contains(s_.global_id(a)) || inside == origins_.end()) return false;
    return std::any_of(inside->second.corners.begin(), inside->second.corners.end(), [&](GlobalId id) {
      const VertexId c = frozen_.at(id);
      return c != a && must_stay(a, c) &&
             length_between(mesh_, a, c) > kClearlyShort * kernel_.limits.long_edge;
    });
  }

  /// Of the side or face of the interface as it was at first that the vertex lies in.
  std::vector<GlobalId> corners_of(GlobalId v) const {
    const auto at = origins_.find(v);
    return at == origins_.end() ? std::vector<GlobalId>{v} : at->second.corners;
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
    const meshing::Background& background = s_.background.background();
    for (const VertexId v : {e.a, e.b})
      if (const auto end = background.walk_towards(x, mesh_.background_hint(v)); end.reached) return end.tet;
    return background.at(x, mesh_.background_hint(e.a)).tet;
  }

  /// The tets around an edge: one of each set of joined ones (every set has two of the faces, at its ends),
  /// and how the edge lies in the boundary, as far as they tell.
  struct Around {
    std::vector<TetId> fans;
    std::vector<TetId> tets;  ///< all of them
    meshing::PatchId patch;
  };
  Around look_around(const Edge& e, const std::vector<TetFace>& faces) {
    Around around;
    std::vector<TetFace> seen;
    const meshing::Shell& shell = worker_.shell;
    for (const TetFace face : faces) {
      if (std::find(seen.begin(), seen.end(), face) != seen.end()) continue;
      worker_.claims.claim_tet(face.tet());
      if (gather_shell(mesh_, worker_.claims, face.tet(), e.a, e.b, worker_.shell) !=
          meshing::Verdict::accepted)
        throw std::runtime_error("an interface edge has more tets around it than " +
                                 std::to_string(meshing::Shell::kMaxSize));
      worker_.claims.release();
      around.fans.push_back(face.tet());
      for (int i = 0; i < shell.size; ++i) around.tets.push_back(shell.tets[i].tet);
      seen.emplace_back(shell.tets[0].tet, shell.tets[0].s);
      seen.emplace_back(shell.tets[shell.size - 1].tet, shell.tets[shell.size - 1].r);
      if (const auto on = meshing::classify(mesh_, shell); on.patch.valid()) around.patch = on.patch;
    }
    return around;
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

  void split(const Edge& e) {
    const std::vector<TetFace> faces = std::move(faces_.at(key(e.a, e.b)));
    faces_.erase(key(e.a, e.b));
    const Around around = look_around(e, faces);
    meshing::VertexOnEdge at = place(e);
    classify(e, around.patch, at);
    for (const TetId t : around.fans) worker_.claims.claim_tet(t);
    const VertexId m = split_edge_at(worker_, e.a, e.b, around.fans, at);
    worker_.claims.release();
    if (!m.valid()) throw std::runtime_error("an interface edge could not be split: a tet would be inverted");
    remember(m, e);
    for (const TetId t : around.tets) rename_face_beyond(t, e);
    for (const TetFace face : faces) replace(face, e, m);
  }

  void remember(VertexId m, const Edge& e) {
    const GlobalId id = GlobalId::derived_from(e.low, e.high);
    mesh_.set_label(m, id.value());
    InterfaceRefinement::Origin origin;
    origin.corners = corners_of(e.low);
    for (const GlobalId c : corners_of(e.high))
      if (std::find(origin.corners.begin(), origin.corners.end(), c) == origin.corners.end())
        origin.corners.push_back(c);
    const std::vector<SubdomainId> x = holders(e.low), y = holders(e.high);
    std::set_intersection(x.begin(), x.end(), y.begin(), y.end(), std::back_inserter(origin.holders));
    origins_.emplace(id, std::move(origin));
    created_.push_back(m);
  }

  std::vector<SubdomainId> holders(GlobalId v) const {
    if (const auto at = origins_.find(v); at != origins_.end()) return at->second.holders;
    std::vector<SubdomainId> all;
    for (const Holder& h : s_.interface.others(s_.interface.find(v))) all.push_back(h.subdomain);
    return all;
  }

  /// The tets of the split edge's upper half are new, and with them the faces opposite its lower end.
  void rename_face_beyond(TetId t, const Edge& e) {
    const int side = mesh_.local_index(t, e.a);
    const TetFace old(t, side), now(mesh_.neighbour(t, side).tet(), side);
    if (!is_interface(now)) return;
    for (int i = 0; i < 3; ++i) {
      const VertexId a = mesh_.vertex(now.tet(), meshing::kTetFaces[side][i]);
      const VertexId b = mesh_.vertex(now.tet(), meshing::kTetFaces[side][(i + 1) % 3]);
      auto& faces = faces_.at(key(a, b));
      std::replace(faces.begin(), faces.end(), old, now);
    }
  }

  /// The face (a, b, c) has become (a, m, c), where it was, and (m, b, c), of the tet across the new face (m,
  /// c, ..).
  void replace(TetFace face, const Edge& e, VertexId m) {
    // The old tet keeps shell.a = a; its face opposite a leads to the new tet.
    const TetId u = mesh_.neighbour(face.tet(), mesh_.local_index(face.tet(), e.a)).tet();
    const TetFace upper(u, face.face());
    for (const VertexId v : mesh_.vertices(face.tet())) {
      if (v == e.a || v == m || v == mesh_.vertex(face.tet(), face.face())) continue;
      auto& old = faces_[key(e.b, v)];  // (b, c) belongs to the upper face now
      std::replace(old.begin(), old.end(), face, upper);
    }
    for (const TetFace half : {face, upper})
      for (int i = 0; i < 3; ++i)
        if (meshing::kTetFaces[half.face()][i] == mesh_.local_index(half.tet(), m)) {
          add_side(half, i);
          add_side(half, (i + 2) % 3);
        }
  }

  Subdomain& s_;
  Origins& origins_;
  const double longest_;
  TetMesh& mesh_;
  const Geometry& geometry_;
  const meshing::Surface& surface_;
  meshing::Kernel kernel_;
  meshing::Worker worker_;
  std::unordered_map<std::uint64_t, std::vector<TetFace>> faces_;  ///< edge -> interface faces that have it
  std::priority_queue<Edge, std::vector<Edge>, ShorterFirst> long_edges_;
  std::unordered_map<GlobalId, VertexId> frozen_;  ///< as they were when the level began
  std::vector<VertexId> created_;
};

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
    : subdomain_(s), geometry_(geometry) {}

void InterfaceRefinement::refine(double longest) { Level(subdomain_, geometry_, origins_, longest).run(); }

std::vector<InterfaceVertices> InterfaceRefinement::created() const {
  const TetMesh& mesh = *subdomain_.mesh;
  const auto neighbours = subdomain_.interface.neighbours();
  std::vector<InterfaceVertices> result(neighbours.size());
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) {
    const VertexId v(i);
    if (!mesh.alive(v) || !mesh.frozen(v)) continue;
    const auto origin = origins_.find(subdomain_.global_id(v));
    if (origin == origins_.end()) continue;
    for (const SubdomainId other : origin->second.holders) {
      const auto at = std::lower_bound(neighbours.begin(), neighbours.end(), other) - neighbours.begin();
      result[at].vertices.push_back({origin->first, mesh.surface_hint(v), mesh.kind(v)});
    }
  }
  for (InterfaceVertices& list : result)
    std::sort(list.vertices.begin(), list.vertices.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
  return result;
}

void register_interface(Subdomain& s, std::span<const InterfaceVertices> theirs) {
  std::unordered_map<GlobalId, VertexId> mine;
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i)
    if (s.mesh->alive(VertexId(i)) && s.mesh->frozen(VertexId(i)) && s.global_id(VertexId(i)).derived())
      mine.emplace(s.global_id(VertexId(i)), VertexId(i));
  std::vector<Holder> lines(s.interface.lines().begin(), s.interface.lines().end());
  const auto neighbours = s.interface.neighbours();
  for (std::size_t n = 0; n < theirs.size(); ++n)
    for (const InterfaceVertices::Vertex& v : theirs[n].vertices) {
      const auto at = mine.find(v.id);
      if (at == mine.end()) continue;
      lines.push_back({v.id, neighbours[n]});
      // Who has the boundary's faces at an edge knows best how it lies in the boundary.
      if (v.kind <= s.mesh->kind(at->second)) continue;
      s.mesh->set_kind(at->second, v.kind);
      s.mesh->set_surface_hint(at->second, v.surface_hint);
    }
  s.interface = Interface(std::move(lines));
  locate_interface(s);
}

}  // namespace weft::partition
