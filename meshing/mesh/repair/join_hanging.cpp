// Rounds: edges first, then faces, as a split edge makes other faces.
#include "meshing/mesh/repair/join_hanging.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "meshing/base/box.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/repair/close_cracks.h"
#include "meshing/mesh/repair/open_faces.h"
#include "meshing/mesh/repair/point_tree.h"

namespace weft::meshing {
namespace {

using OpenEdge = std::array<std::uint32_t, 2>;  // ascending

OpenEdge open_edge(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

template <class Row>
bool has_vertex(const Row& row, std::uint32_t v) {
  return std::find(row.begin(), row.end(), v) != row.end();
}

template <class Row>
Row with_vertex(Row row, std::uint32_t old, std::uint32_t now) {
  std::replace(row.begin(), row.end(), old, now);
  return row;
}

/// Tets, triangles or edges, with those at each of some vertices.
template <std::size_t N>
class Splittable {
 public:
  using Row = std::array<std::uint32_t, N>;
  Splittable(std::vector<Row>& rows, std::vector<std::int32_t>& refs, std::vector<std::uint32_t>& parents)
      : rows_(rows), refs_(refs), parents_(parents) {}

  void find_at(const std::vector<std::uint32_t>& vertices) {
    at_.clear();
    for (const std::uint32_t v : vertices) at_[v];
    for (std::uint32_t i = 0; i < rows_.size(); ++i) note(i);
  }

  std::vector<std::uint32_t> at_edge(const OpenEdge& e) const {
    std::vector<std::uint32_t> found;
    auto list = at_.find(e[0]);
    if (list == at_.end()) list = at_.find(e[1]);
    for (const std::uint32_t i : list->second)
      if (has_vertex(rows_[i], e[0]) && has_vertex(rows_[i], e[1])) found.push_back(i);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  const Row& row(std::uint32_t i) const { return rows_[i]; }

  /// The row becomes one of the parts, the others are appended.
  void replace(std::uint32_t i, std::initializer_list<Row> parts) {
    rows_[i] = *parts.begin();
    note(i);
    for (auto part = parts.begin() + 1; part != parts.end(); ++part) {
      rows_.push_back(*part);
      refs_.push_back(refs_[i]);
      parents_.push_back(i);
      note(static_cast<std::uint32_t>(rows_.size() - 1));
    }
  }

  void split(const OpenEdge& e, std::uint32_t n) {
    for (const std::uint32_t i : at_edge(e)) {
      const Row row = rows_[i];
      replace(i, {with_vertex(row, e[1], n), with_vertex(row, e[0], n)});
    }
  }

 private:
  void note(std::uint32_t i) {
    for (const std::uint32_t v : rows_[i])
      if (const auto list = at_.find(v); list != at_.end()) list->second.push_back(i);
  }

  std::vector<Row>& rows_;
  std::vector<std::int32_t>& refs_;
  std::vector<std::uint32_t>& parents_;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> at_;  ///< may name a row twice, or wrongly
};

class HangingVertices {
 public:
  explicit HangingVertices(MeshData& mesh) : m_(mesh) {
    Box box;
    for (const Tet& t : m_.tets)
      for (const std::uint32_t v : t) box.include(m_.points[v]);
    largest_ = kNearlyThere * norm(box.size());
  }

  HangingJoins run() {
    const std::size_t triangles = m_.triangles.size(), edges = m_.edges.size();
    while (round()) {
    }
    extend(m_.required_triangles, triangles, joins_.triangles);
    extend(m_.required_edges, edges, joins_.edges);
    extend(m_.ridges, edges, joins_.edges);
    return std::move(joins_);
  }

 private:
  /// What a list names is there with all its parts.
  static void extend(std::vector<std::uint32_t>& list, std::size_t first,
                     const std::vector<std::uint32_t>& parents) {
    std::unordered_set<std::uint32_t> listed(list.begin(), list.end());
    for (std::size_t i = 0; i < parents.size(); ++i)
      if (listed.contains(parents[i])) {
        list.push_back(static_cast<std::uint32_t>(first + i));
        listed.insert(list.back());
      }
  }

  /// Whether anything has changed.
  bool round() {
    open_ = open_faces(m_);
    if (open_.empty()) return false;
    std::vector<std::uint32_t> vertices;
    edges_.clear();
    for (const OpenFace& face : open_)
      for (std::size_t i = 0; i < 3; ++i) {
        vertices.push_back(face.vertices[i]);
        edges_.push_back(open_edge(face.vertices[i], face.vertices[(i + 1) % 3]));
      }
    make_unique(vertices);
    make_unique(edges_);
    const PointTree tree(m_.points, vertices);
    tree_ = &tree;
    return swap_pairs() || split_edges(vertices) || split_faces() || split_loose_triangles(vertices);
  }

  template <class T>
  static void make_unique(std::vector<T>& items) {
    std::sort(items.begin(), items.end());
    items.erase(std::unique(items.begin(), items.end()), items.end());
  }

  bool is_open(std::uint32_t a, std::uint32_t b) const {
    return std::binary_search(edges_.begin(), edges_.end(), open_edge(a, b));
  }
  double tolerance(double length) const { return std::min(largest_, kNearlyThereOfEdge * length); }

  struct Place {
    double from_middle, distance;
    std::uint32_t vertex;
    friend auto operator<=>(const Place&, const Place&) = default;
  };

  /// Vertices on what has these corners, `measure` says how; only those that an open edge joins to one of the
  /// corners or to each other. Those near the middle first: so few rounds do where there are many.
  template <std::size_t N, class Measure>
  std::vector<Place> places_on(const std::array<std::uint32_t, N>& corners, double tolerance,
                               const Measure& measure) const {
    Box box;
    for (const std::uint32_t v : corners) box.include(m_.points[v]);
    std::vector<Place> places;
    tree_->visit_in(box.grown(tolerance), [&](std::uint32_t n) {
      Place place{0, 0, n};
      if (!has_vertex(corners, n) && measure(m_.points[n], place)) places.push_back(place);
    });
    std::sort(places.begin(), places.end());
    const std::vector<Place> all = places;
    std::erase_if(places, [&](const Place& p) {
      const auto joined = [&](std::uint32_t v) { return is_open(p.vertex, v); };
      return std::none_of(corners.begin(), corners.end(), joined) &&
             std::none_of(all.begin(), all.end(), [&](const Place& other) { return joined(other.vertex); });
    });
    return places;
  }

  std::vector<Place> places_on_edge(const OpenEdge& e) const {
    const Point a = m_.points[e[0]], along = m_.points[e[1]] - a;
    const double length = norm(along), within = tolerance(length);
    return places_on(e, within, [&](const Point& p, Place& place) {
      const double at = dot(p - a, along) / length;
      place.distance = norm(p - a - (at / length) * along);
      place.from_middle = std::abs(at - 0.5 * length);
      return place.distance <= within && at > within && at < length - within;
    });
  }

  std::vector<Place> places_in_face(const Triangle& t) const {
    const std::array<Point, 3> p = {m_.points[t[0]], m_.points[t[1]], m_.points[t[2]]};
    const Vec normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
    const Point middle = (1.0 / 3) * (p[0] + p[1] + p[2]);
    const double within = tolerance(std::min({norm(p[1] - p[0]), norm(p[2] - p[1]), norm(p[0] - p[2])}));
    return places_on(t, within, [&](const Point& q, Place& place) {
      place.distance = std::abs(dot(normal, q - p[0]));
      place.from_middle = norm(q - middle);
      bool inside = place.distance <= within;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec side = p[(i + 1) % 3] - p[i];
        inside = inside && dot(cross(side, q - p[i]), normal) > within * norm(side);
      }
      return inside;
    });
  }

  int sign_of(const Tet& t) const {
    return orientation(m_.points[t[0]], m_.points[t[1]], m_.points[t[2]], m_.points[t[3]]);
  }
  /// A tet keeps its orientation when the vertex takes the place of any one of these.
  template <std::size_t N>
  bool may_split(const Tet& t, const std::array<std::uint32_t, N>& corners, std::uint32_t n) const {
    if (has_vertex(t, n)) return false;
    const int sign = sign_of(t);
    return std::all_of(corners.begin(), corners.end(),
                       [&](std::uint32_t v) { return sign_of(with_vertex(t, v, n)) == sign; });
  }

  void joined(const Place& place) {
    double& distance = joins_.vertices[place.vertex];
    distance = std::max(distance, place.distance);
  }

  bool split_edges(const std::vector<std::uint32_t>& vertices) {
    std::vector<std::pair<OpenEdge, std::vector<Place>>> splits;
    for (const OpenEdge& e : edges_)
      if (auto places = places_on_edge(e); !places.empty()) splits.emplace_back(e, std::move(places));
    if (splits.empty()) return false;
    find_at(vertices);
    bool any = false;
    for (const auto& [e, places] : splits)
      for (const Place& place : places) {
        const std::vector<std::uint32_t> around = tets_.at_edge(e);
        const bool may = std::all_of(around.begin(), around.end(), [&, &e = e](std::uint32_t t) {
          return may_split(tets_.row(t), e, place.vertex);
        });
        if (!may) continue;
        split(e, place.vertex);
        joined(place);
        any = true;
        break;
      }
    return any;
  }

  void find_at(const std::vector<std::uint32_t>& vertices) {
    tets_.find_at(vertices);
    triangles_.find_at(vertices);
    mesh_edges_.find_at(vertices);
  }
  void split(const OpenEdge& e, std::uint32_t n) {
    tets_.split(e, n);
    triangles_.split(e, n);
    mesh_edges_.split(e, n);
  }

  /// Where the two sides of a quadrangle have been cut along different diagonals, the pair of tets on one of
  /// them is turned to the other's.
  bool swap_pairs() {
    std::vector<std::pair<OpenEdge, std::uint32_t>> sides;  // edge, number of the open face
    for (std::uint32_t i = 0; i < open_.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        sides.emplace_back(open_edge(open_[i].vertices[k], open_[i].vertices[(k + 1) % 3]), i);
    std::sort(sides.begin(), sides.end());
    swapped_.clear(), listed_.clear();
    for (std::size_t i = 0; i < sides.size(); ++i)
      for (std::size_t j = i + 1; j < sides.size() && sides[j].first == sides[i].first; ++j)
        swap_pair(sides[i].first, open_[sides[i].second], open_[sides[j].second]);
    return !swapped_.empty();
  }

  static std::uint32_t corner_off(const OpenEdge& e, const Triangle& t) {
    return *std::find_if(t.begin(), t.end(), [&](std::uint32_t v) { return !has_vertex(e, v); });
  }

  /// Of the tets at two open faces that share an edge: they must be the only ones there between them.
  void swap_pair(const OpenEdge& e, const OpenFace& f, const OpenFace& g) {
    const std::uint32_t s = f.code >> 2, t = g.code >> 2, apex = m_.tets[s][f.code & 3];
    const std::uint32_t c = corner_off(e, f.vertices), d = corner_off(e, g.vertices);
    if (s == t || c == d || m_.tets[t][g.code & 3] != apex || m_.tet_refs[s] != m_.tet_refs[t]) return;
    const OpenFace* beyond[] = {find_open({e[0], c, d}), find_open({e[1], c, d})};
    for (const OpenFace* other : beyond)
      if (!other || !is_beyond(*other, apex)) return;
    const std::array<std::uint32_t, 4> involved = {s, t, beyond[0]->code >> 2, beyond[1]->code >> 2};
    if (std::any_of(involved.begin(), involved.end(),
                    [&](std::uint32_t i) { return swapped_.contains(i); }) ||
        is_listed({e[0], e[1], apex}))
      return;
    const Tet one = with_vertex(m_.tets[s], e[1], d), two = with_vertex(m_.tets[t], e[0], c);
    if (sign_of(one) != sign_of(m_.tets[s]) || sign_of(two) != sign_of(m_.tets[t])) return;
    m_.tets[s] = one;
    m_.tets[t] = two;
    joins_.swapped.push_back(s);
    swapped_.insert(involved.begin(), involved.end());
  }

  const OpenFace* find_open(Triangle t) const {
    std::sort(t.begin(), t.end());
    const auto found = std::lower_bound(open_.begin(), open_.end(), OpenFace{t, 0});
    return found != open_.end() && found->vertices == t ? &*found : nullptr;
  }

  bool is_listed(Triangle t) {
    const auto ascending = [](Triangle v) {
      std::sort(v.begin(), v.end());
      return v;
    };
    if (listed_.empty())
      for (const Triangle& triangle : m_.triangles) listed_.insert(ascending(triangle));
    return listed_.contains(ascending(t));
  }

  /// Whether the face's tet lies on the other side of it than a vertex.
  bool is_beyond(const OpenFace& face, std::uint32_t v) const {
    const Triangle& t = face.vertices;
    const auto side = [&](std::uint32_t w) {
      return orientation(m_.points[t[0]], m_.points[t[1]], m_.points[t[2]], m_.points[w]);
    };
    return side(v) * side(m_.tets[face.code >> 2][face.code & 3]) < 0;
  }

  bool split_faces() {
    std::unordered_set<std::uint32_t> done;  // a tet that has been split has its other faces elsewhere
    for (const OpenFace& face : open_) {
      const std::uint32_t t = face.code >> 2;
      if (done.contains(t)) continue;
      for (const Place& place : places_in_face(face.vertices))
        if (may_split(m_.tets[t], face.vertices, place.vertex)) {
          split_in_three(tets_, t, face.vertices, place.vertex);
          joined(place);
          done.insert(t);
          break;
        }
    }
    return !done.empty();
  }

  template <std::size_t N>
  static void split_in_three(Splittable<N>& rows, std::uint32_t i, const Triangle& face, std::uint32_t n) {
    const auto row = rows.row(i);
    rows.replace(i,
                 {with_vertex(row, face[0], n), with_vertex(row, face[1], n), with_vertex(row, face[2], n)});
  }

  /// Triangles that are no faces although their parts are: their tet was split without them.
  bool split_loose_triangles(const std::vector<std::uint32_t>& vertices) {
    std::vector<std::uint32_t> near;
    for (std::uint32_t i = 0; i < m_.triangles.size(); ++i)
      if (std::all_of(m_.triangles[i].begin(), m_.triangles[i].end(),
                      [&](std::uint32_t v) { return v < m_.points.size(); }))
        near.push_back(i);
    std::vector<Triangle> triangles;
    for (const std::uint32_t i : near) triangles.push_back(m_.triangles[i]);
    const std::vector<std::uint32_t> codes = match_triangles(triangles, m_.tets, m_.points.size());
    bool any = false;
    for (std::size_t k = 0; k < near.size(); ++k) {
      if (codes[k] != kNoNeighbour) continue;
      if (!any) find_at(vertices);
      any |= split_loose_triangle(near[k]);
    }
    return any;
  }

  bool split_loose_triangle(std::uint32_t i) {
    const Triangle t = m_.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const OpenEdge e = open_edge(t[k], t[(k + 1) % 3]);
      for (const Place& place : places_on_edge(e)) {
        if (!is_open(place.vertex, t[(k + 2) % 3])) continue;
        if (tets_.at_edge(e).empty()) mesh_edges_.split(e, place.vertex);
        triangles_.replace(i, {with_vertex(t, e[1], place.vertex), with_vertex(t, e[0], place.vertex)});
        return true;
      }
    }
    for (const Place& place : places_in_face(t)) {
      const bool joined =
          std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return is_open(place.vertex, v); });
      if (joined) return split_in_three(triangles_, i, t, place.vertex), true;
    }
    return false;
  }

  MeshData& m_;
  double largest_ = 0;
  HangingJoins joins_;
  std::vector<OpenFace> open_;
  std::vector<OpenEdge> edges_;  ///< of the open faces
  const PointTree* tree_ = nullptr;
  std::set<Triangle> listed_;                  ///< made when it is asked for
  std::unordered_set<std::uint32_t> swapped_;  ///< tets of this round
  Splittable<4> tets_{m_.tets, m_.tet_refs, joins_.tets};
  Splittable<3> triangles_{m_.triangles, m_.triangle_refs, joins_.triangles};
  Splittable<2> mesh_edges_{m_.edges, m_.edge_refs, joins_.edges};
};

}  // namespace

HangingJoins join_hanging_vertices(MeshData& mesh) { return HangingVertices(mesh).run(); }

}  // namespace weft::meshing
