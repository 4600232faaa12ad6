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

class Refinement {
 public:
  Refinement(Subdomain& s, const Geometry& geometry)
      : s_(s),
        mesh_(*s.mesh),
        geometry_(geometry),
        surface_(geometry.surface),
        kernel_{mesh_, s.background.background(), geometry.surface, {}},
        worker_(kernel_, 1, true) {}

  std::vector<InterfaceVertices> run() {
    mesh_.set_metric_mean(meshing::MetricMean::arithmetic);
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i)
      for (int f = 0; f < 4; ++f)
        if (const TetFace face(TetId(i), f); mesh_.alive(TetId(i)) && is_interface(face)) add_face(face);
    while (!long_edges_.empty()) {
      const Edge e = long_edges_.top();
      long_edges_.pop();
      split(e);
    }
    return vertices_by_neighbour();
  }

 private:
  static std::uint64_t key(VertexId a, VertexId b) {
    return std::uint64_t{std::min(a, b).value} << 32 | std::max(a, b).value;
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
    if (length > kernel_.limits.long_edge && may_split(a, b))
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
    const auto corners = corners_.find(b.value);
    if (corners_.contains(a.value) || corners == corners_.end()) return false;
    return std::any_of(corners->second.begin(), corners->second.end(), [&](VertexId c) {
      return c != a && must_stay(a, c) &&
             length_between(mesh_, a, c) > kClearlyShort * kernel_.limits.long_edge;
    });
  }

  /// Of the side or face of the interface as it was at first that the vertex lies in.
  std::vector<VertexId> corners_of(VertexId v) const {
    const auto at = corners_.find(v.value);
    return at == corners_.end() ? std::vector<VertexId>{v} : at->second;
  }

  meshing::VertexOnEdge place(const Edge& e) const {
    const Vec d = mesh_.point(e.b) - mesh_.point(e.a);
    const double share = meshing::metric_middle(std::sqrt(squared_length(mesh_.metric(e.a), d)),
                                                std::sqrt(squared_length(mesh_.metric(e.b), d)));
    meshing::VertexOnEdge at;
    at.x = mesh_.point(e.a) + share * d;
    at.log_metric = (1 - share) * mesh_.log_metric(e.a) + share * mesh_.log_metric(e.b);
    at.curve = mesh_.curve(e.a, e.b);
    at.background_hint = s_.background.background().at(at.x, mesh_.background_hint(e.a)).tet;
    return at;
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
    std::vector<VertexId> corners = corners_of(e.a);
    for (const VertexId c : corners_of(e.b))
      if (std::find(corners.begin(), corners.end(), c) == corners.end()) corners.push_back(c);
    corners_.emplace(m.value, std::move(corners));
    std::vector<SubdomainId> common;
    const std::vector<SubdomainId>&x = holders(e.a), &y = holders(e.b);
    std::set_intersection(x.begin(), x.end(), y.begin(), y.end(), std::back_inserter(common));
    candidates_.emplace(m.value, std::move(common));
    created_.push_back(m);
  }

  const std::vector<SubdomainId>& holders(VertexId v) {
    const auto [at, is_new] = candidates_.try_emplace(v.value);
    if (is_new)
      for (const Holder& h : s_.interface.others(s_.interface.find(s_.global_id(v))))
        at->second.push_back(h.subdomain);
    return at->second;
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

  std::vector<InterfaceVertices> vertices_by_neighbour() {
    const auto neighbours = s_.interface.neighbours();
    std::vector<InterfaceVertices> result(neighbours.size());
    for (const VertexId v : created_) {
      mesh_.freeze(v);
      for (const SubdomainId other : candidates_.at(v.value)) {
        const auto at = std::lower_bound(neighbours.begin(), neighbours.end(), other) - neighbours.begin();
        result[at].vertices.push_back(
            {s_.global_id(v), mesh_.surface_hint(v), mesh_.kind(v), mesh_.flags(v)});
      }
    }
    for (InterfaceVertices& list : result)
      std::sort(list.vertices.begin(), list.vertices.end(),
                [](const auto& a, const auto& b) { return a.id < b.id; });
    return result;
  }

  Subdomain& s_;
  TetMesh& mesh_;
  const Geometry& geometry_;
  const meshing::Surface& surface_;
  meshing::Kernel kernel_;
  meshing::Worker worker_;
  std::unordered_map<std::uint64_t, std::vector<TetFace>> faces_;  ///< edge -> interface faces that have it
  std::priority_queue<Edge, std::vector<Edge>, ShorterFirst> long_edges_;
  std::unordered_map<std::uint32_t, std::vector<SubdomainId>> candidates_;  ///< vertex -> who may have it too
  std::unordered_map<std::uint32_t, std::vector<VertexId>> corners_;        ///< of created_: see corners_of
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

std::vector<InterfaceVertices> refine_interface(Subdomain& s, const Geometry& geometry) {
  return Refinement(s, geometry).run();
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
