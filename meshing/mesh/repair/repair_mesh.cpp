// The mends, one after the other.
#include "meshing/mesh/repair/repair_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <unordered_map>

#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/renumber_vertices.h"
#include "meshing/mesh/repair/close_cracks.h"
#include "meshing/mesh/repair/join_hanging.h"
#include "meshing/mesh/repair/open_faces.h"
#include "meshing/mesh/repair/point_tree.h"
#include "meshing/mesh/repair/signed_tets.h"
#include "meshing/mesh/repair/untangle.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {
namespace {

constexpr std::uint32_t kGone = 0xFFFFFFFFu;

template <std::size_t N>
std::array<std::uint32_t, N> in_order(std::array<std::uint32_t, N> v) {
  std::sort(v.begin(), v.end());
  return v;
}

template <std::size_t N>
bool repeats(const std::array<std::uint32_t, N>& v) {
  const auto s = in_order(v);
  return std::adjacent_find(s.begin(), s.end()) != s.end();
}

class Repair {
 public:
  explicit Repair(MeshData& mesh) : m_(mesh) {
    complete(m_.point_refs, m_.points.size());
    complete(m_.tet_refs, m_.tets.size());
    complete(m_.triangle_refs, m_.triangles.size());
    complete(m_.edge_refs, m_.edges.size());
    number(tet_source_, m_.tets.size());
    number(triangle_source_, m_.triangles.size());
    number(edge_source_, m_.edges.size());
  }

  MeshRepair run() {
    check_points();
    merge_points();
    drop_degenerate_tets();
    close_cracks();
    join_hanging();
    drop_overlapping_tets();
    turn_tets();
    untangle(VertexGroup::inner);
    drop_flat_tets();
    untangle(VertexGroup::boundary);
    untangle(VertexGroup::ridge);
    refuse_what_is_left();
    mend_triangles();
    mend_edges();
    drop_unused_points();
    return std::move(result_);
  }

 private:
  static void complete(std::vector<std::int32_t>& refs, std::size_t count) {
    if (refs.empty()) refs.assign(count, 0);
  }

  static void number(std::vector<std::uint32_t>& source, std::size_t count) {
    source.resize(count);
    std::iota(source.begin(), source.end(), 0u);
  }

  MeshMend& mend(const char* what, const char* entity, const char* unit = "") {
    for (MeshMend& known : result_.mends)
      if (known.what == what) return known;
    result_.mends.push_back({what, entity, 0, {}, 0, unit});
    return result_.mends.back();
  }

  /// A vertex without a place that a tet needs cannot be mended.
  void check_points() {
    const auto finite = [](const Point& p) { return std::isfinite(p.x + p.y + p.z); };
    for (std::size_t t = 0; t < m_.tets.size(); ++t)
      for (const std::uint32_t v : m_.tets[t]) {
        if (v >= m_.points.size())
          throw InputError("", fmt::format("tet {}", t + 1), fmt::format("has no vertex {}", v + 1));
        if (!finite(m_.points[v]))
          throw InputError("", fmt::format("vertex {}", v + 1), "has a coordinate that is not finite");
      }
    Box box;
    for (const Tet& t : m_.tets)
      for (const std::uint32_t v : t) box.include(m_.points[v]);
    if (m_.tets.empty()) box.include({});
    Point free = box.hi;
    for (Point& p : m_.points)  // no tet has them: where nothing else is, until they are removed
      if (!finite(p)) p = free = free + box.size();
  }

  // --- Vertices

  void merge_points() {
    constexpr double kTolerance = 1e-12;
    Box box;
    for (const Tet& t : m_.tets)  // what nobody uses may be anywhere
      for (const std::uint32_t v : t) box.include(m_.points[v]);
    const double tolerance = kTolerance * norm(box.size());
    std::vector<std::uint32_t> order(m_.points.size()), now(m_.points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::iota(now.begin(), now.end(), 0u);
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
      const double x = m_.points[a].x, y = m_.points[b].x;
      return x != y ? x < y : a < b;
    };
    std::sort(order.begin(), order.end(), before);
    const VertexLists tets = vertex_tets(m_.tets, m_.points.size());
    const PointTree tree(m_.points, order);
    std::vector<std::uint32_t> near;
    for (const std::uint32_t a : order) {
      near.clear();
      Box place;
      place.include(m_.points[a]);
      tree.visit_in(place.grown(tolerance), [&](std::uint32_t b) {
        if (before(a, b)) near.push_back(b);
      });
      std::sort(near.begin(), near.end(), before);
      for (const std::uint32_t b : near) merge(a, b, tolerance, tets, now);
    }
    renumber_points(now);
  }

  /// Where vertices lie on a CAD model; those of vertices that are gone go.
  void renumber_records(const std::vector<std::uint32_t>& now) {
    const auto renumber = [&](auto& records) {
      std::erase_if(records, [&](const auto& r) { return r.vertex >= now.size() || now[r.vertex] == kGone; });
      for (auto& r : records) r.vertex = now[r.vertex];
    };
    renumber(m_.association.nodes);
    renumber(m_.association.edges);
    renumber(m_.association.faces);
  }

  void renumber_points(const std::vector<std::uint32_t>& now) {
    renumber_vertices(m_.tets, now);
    renumber_records(now);
    const auto renumber = [&](auto& entities) {
      for (auto& e : entities)
        for (std::uint32_t& v : e) v = v < now.size() ? now[v] : kGone;
    };
    renumber(m_.triangles);
    renumber(m_.edges);
    for (auto* list : {&m_.corners, &m_.required_points})
      for (std::uint32_t& v : *list) v = v < now.size() ? now[v] : kGone;
  }

  void merge(std::uint32_t a, std::uint32_t b, double tolerance, const VertexLists& tets,
             std::vector<std::uint32_t>& now) {
    if (now[a] == now[b]) return;
    const double distance = norm(m_.points[a] - m_.points[b]);
    if (!(distance <= tolerance) || now[b] != b) return;
    const std::uint32_t into = now[a], from = b;
    for (const std::uint32_t t : tets.of(from)) {  // a tet that has volume must not lose it
      const auto& v = m_.tets[t];
      if (std::find_if(v.begin(), v.end(), [&](std::uint32_t x) { return now[x] == into; }) != v.end() &&
          sign_of(m_, v) != 0)
        return;
    }
    now[from] = into;
    tell_merged(from, distance);
  }
  void tell_merged(std::uint32_t v, double distance) {
    mend("vertices at the same place merged", "vertex", "distance").add(v, distance);
  }

  void close_cracks() {
    const auto merges = cracks_to_close(m_);
    if (merges.empty()) return;
    std::vector<std::uint32_t> now;
    number(now, m_.points.size());
    for (const auto& [from, into] : merges) {
      now[from] = into;
      tell_merged(from, norm(m_.points[from] - m_.points[into]));
    }
    renumber_points(now);
  }

  void join_hanging() {
    const HangingJoins joins = join_hanging_vertices(m_);
    for (const auto& [v, distance] : joins.vertices)
      mend("hanging vertices joined", "vertex", "distance").add(v, distance);
    const auto extend = [](std::vector<std::uint32_t>& source, const std::vector<std::uint32_t>& parents) {
      for (const std::uint32_t p : parents) source.push_back(source[p]);
    };
    extend(tet_source_, joins.tets);
    for (const std::uint32_t t : joins.swapped)
      mend("pairs of tets swapped to fit what is beyond their faces", "tet").add(tet_source_[t]);
    extend(triangle_source_, joins.triangles);
    extend(edge_source_, joins.edges);
  }

  void drop_unused_points() {
    std::vector<std::uint32_t> new_index(m_.points.size(), kGone);
    std::vector<bool> used(m_.points.size());
    for (const auto& t : m_.tets)
      for (const std::uint32_t v : t) used[v] = true;
    std::uint32_t kept = 0;
    for (std::uint32_t v = 0; v < m_.points.size(); ++v) {
      if (!used[v]) {
        mend("unused vertices removed", "vertex").add(v);
        continue;
      }
      new_index[v] = kept;
      m_.points[kept] = m_.points[v];
      m_.point_refs[kept++] = m_.point_refs[v];
      result_.points.push_back(v);
    }
    m_.points.resize(kept), m_.point_refs.resize(kept);
    renumber_vertices(m_.tets, new_index);
    renumber_vertices(m_.triangles, new_index);
    renumber_vertices(m_.edges, new_index);
    renumber_records(new_index);
    for (auto* list : {&m_.corners, &m_.required_points}) {
      std::set<std::uint32_t> there;
      for (const std::uint32_t v : *list)
        if (v < new_index.size() && new_index[v] != kGone) there.insert(new_index[v]);
      list->assign(there.begin(), there.end());
    }
  }

  // --- Tets

  void erase_tets(const std::vector<bool>& drop) {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < m_.tets.size(); ++t) {
      if (drop[t]) continue;
      m_.tets[kept] = m_.tets[t];
      m_.tet_refs[kept] = m_.tet_refs[t];
      tet_source_[kept++] = tet_source_[t];
    }
    m_.tets.resize(kept), m_.tet_refs.resize(kept), tet_source_.resize(kept);
    if (kept == 0) throw InputError("", "Tetrahedra", "none is left when those without volume are removed");
  }

  void drop_degenerate_tets() {
    std::vector<bool> drop(m_.tets.size());
    std::map<Tet, std::int32_t> there;
    for (std::size_t t = 0; t < m_.tets.size(); ++t) {
      const bool degenerate = repeats(m_.tets[t]);
      const auto [known, is_new] = there.try_emplace(in_order(m_.tets[t]), m_.tet_refs[t]);
      drop[t] = degenerate || !is_new;
      if (!drop[t]) continue;
      mend(degenerate                        ? "tets with a repeated vertex removed"
           : known->second == m_.tet_refs[t] ? "repeated tets removed"
                                             : "repeated tets with another reference removed",
           "tet")
          .add(tet_source_[t]);
    }
    erase_tets(drop);
  }

  using Faces = std::span<const OpenFace>;  ///< with the same vertices

  /// Three tets at a face, or two on the same side of it: what is listed the wrong way round, or lies so, is
  /// not.
  bool overlap(Faces at) const {
    if (at.size() != 2) return at.size() > 2;
    const std::uint32_t a = at[0].code, b = at[1].code;
    const int sign = sign_of(m_, m_.tets[a >> 2]);
    return sign != 0 && sign == sign_of(m_, m_.tets[b >> 2]) &&
           !turns_alike(m_.tets[a >> 2], static_cast<int>(a & 3), m_.tets[b >> 2], static_cast<int>(b & 3));
  }

  /// A tet that nothing but such a face joins to the others, and that has none of the triangles, is the one
  /// too many. Of three tets at a face nobody can tell else; of two one may lie the wrong way round
  /// (untangle()).
  void drop_overlapping_tets() {
    const std::vector<OpenFace> faces = sorted_faces(m_);
    std::vector<std::uint8_t> partners(m_.tets.size(), 0);  // faces that other tets have too
    std::vector<Faces> overlaps;
    for (std::size_t i = 0, end = 0; i < faces.size(); i = end) {
      while (end < faces.size() && faces[end].vertices == faces[i].vertices) ++end;
      if (end - i < 2) continue;
      const Faces at = Faces(faces).subspan(i, end - i);
      for (const OpenFace& face : at) ++partners[face.code >> 2];
      if (overlap(at)) overlaps.push_back(at);
    }
    if (overlaps.empty()) return;
    std::set<Triangle> listed;
    for (const Triangle& t : m_.triangles) listed.insert(in_order(t));
    const auto is_loose = [&](const OpenFace& face) {
      const Tet& tet = m_.tets[face.code >> 2];
      bool loose = partners[face.code >> 2] == 1 && !listed.empty();
      for (std::uint32_t f = 0; f < 4; ++f)
        loose =
            loose && (f == (face.code & 3) || !listed.contains(in_order(face_of(tet, static_cast<int>(f)))));
      return loose;
    };
    std::vector<bool> drop(m_.tets.size());
    for (const Faces at : overlaps) {
      const auto loose = std::ranges::find_if(at, is_loose);
      if (std::ranges::count_if(at, is_loose) == 1 && at.size() <= 3) {
        drop[loose->code >> 2] = true;
        mend("overlapping tets removed", "tet").add(tet_source_[loose->code >> 2]);
      } else if (at.size() > 2) {
        refuse_overlap(at);
      }
    }
    erase_tets(drop);
  }

  [[noreturn]] void refuse_overlap(Faces at) const {
    std::string tets;
    for (std::size_t i = 0; i < at.size(); ++i)
      tets += fmt::format("{}{}",
                          i == 0               ? ""
                          : i + 1 == at.size() ? " and "
                                               : ", ",
                          tet_source_[at[i].code >> 2] + 1);
    const Triangle& v = at[0].vertices;
    throw InputError("", "tets " + tets,
                     fmt::format("share the face ({} {} {})", v[0] + 1, v[1] + 1, v[2] + 1));
  }

  /// Whether two tets across a face turn it in opposite ways.
  bool turns_alike(const Tet& a, int fa, const Tet& b, int fb) const {
    const Triangle x = face_of(a, fa), y = face_of(b, fb);
    const auto at = static_cast<std::size_t>(std::find(y.begin(), y.end(), x[0]) - y.begin());
    return y[(at + 1) % 3] != x[1];
  }

  /// A tet whose order disagrees with that of all its neighbours is listed the wrong way round; so are all
  /// when more volume is negative than positive. One that agrees, and is negative, lies the wrong way round.
  void turn_tets() {
    const Adjacency adjacency = build_adjacency(m_.tets, m_.points.size());
    std::vector<int> side(m_.tets.size(), 0);  // +1: as listed, -1: the other way round
    for (std::uint32_t first = 0; first < m_.tets.size(); ++first) {
      if (side[first] != 0) continue;
      std::vector<std::uint32_t> component = {first};
      side[first] = 1;
      double sum = 0;
      for (std::size_t i = 0; i < component.size(); ++i) {
        const std::uint32_t t = component[i];
        sum += side[t] * volume(m_, m_.tets[t]);
        for (int f = 0; f < 4; ++f) {
          const std::uint32_t n = adjacency.neighbours[t][f];
          if (n == kNoNeighbour || side[n >> 2] != 0) continue;
          const bool alike = turns_alike(m_.tets[t], f, m_.tets[n >> 2], static_cast<int>(n & 3));
          side[n >> 2] = alike ? side[t] : -side[t];
          component.push_back(n >> 2);
        }
      }
      for (const std::uint32_t t : component)
        if ((sum < 0 ? -side[t] : side[t]) < 0) {
          if (sign_of(m_, m_.tets[t]) > 0) against_neighbours_.insert(tet_source_[t]);
          std::swap(m_.tets[t][2], m_.tets[t][3]);
          mend("tets listed the wrong way round turned", "tet", "volume")
              .add(tet_source_[t], std::abs(volume(m_, m_.tets[t])));
        }
    }
  }

  void untangle(VertexGroup group) {
    for (const MovedPoint& moved : meshing::untangle(m_, group))
      mend(group == VertexGroup::inner ? "vertices of inverted or flat tets moved"
           : group == VertexGroup::boundary
               ? "vertices of the boundary at inverted or flat tets moved"
               : "vertices of ridges, and beside them, at inverted or flat tets moved",
           "vertex", "distance")
          .add(moved.vertex, norm(m_.points[moved.vertex] - moved.from));
  }

  /// What lies flat on the boundary adds nothing to the domain.
  void drop_flat_tets() {
    for (;;) {
      const Adjacency adjacency = build_adjacency(m_.tets, m_.points.size());
      std::vector<bool> drop(m_.tets.size());
      bool any = false;
      for (const std::uint32_t t : tets_not_positive(m_)) {
        const auto& n = adjacency.neighbours[t];
        if (sign_of(m_, m_.tets[t]) != 0 || std::count(n.begin(), n.end(), kNoNeighbour) == 0) continue;
        drop[t] = any = true;
        flat_.push_back(m_.tets[t]);
        mend("flat tets at the boundary removed", "tet").add(tet_source_[t]);
      }
      if (!any) return;
      erase_tets(drop);
    }
  }

  void refuse_what_is_left() const {
    for (const std::uint32_t t : tets_not_positive(m_))
      throw InputError("", fmt::format("tet {}", tet_source_[t] + 1),
                       against_neighbours_.contains(tet_source_[t])
                           ? "overlaps a neighbour: both lie on the same side of their common face"
                       : sign_of(m_, m_.tets[t]) < 0
                           ? "is inverted, and moving its vertices does not help"
                           : "is flat, and neither at the boundary nor mended by moving its vertices");
  }

  // --- Triangles, edges, lists

  void mend_triangles() {
    for (auto& t : m_.triangles)
      if (std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return v >= m_.points.size(); }))
        t = {0, 0, 0};
    std::vector<bool> drop(m_.triangles.size());
    const std::vector<std::uint32_t> codes = match_triangles(m_.triangles, m_.tets, m_.points.size());
    std::map<Triangle, std::uint32_t> there;  // by their new numbers
    std::vector<std::uint32_t> new_index(m_.triangles.size(), kGone);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < m_.triangles.size(); ++i) {
      const bool degenerate = repeats(m_.triangles[i]);
      if (degenerate || codes[i] == kNoNeighbour) {
        mend("triangles that are no faces of tets removed", "triangle").add(triangle_source_[i]);
        if (!degenerate) remember_ref(m_.triangles[i], m_.triangle_refs[i]);
        continue;
      }
      const auto [known, is_new] =
          there.try_emplace(in_order(m_.triangles[i]), static_cast<std::uint32_t>(kept));
      new_index[i] = known->second;  // what stays is required if one of them was
      if (!is_new) {
        mend(m_.triangle_refs[known->second] == m_.triangle_refs[i]
                 ? "repeated triangles removed"
                 : "repeated triangles with another reference removed",
             "triangle")
            .add(triangle_source_[i]);
        continue;
      }
      m_.triangles[kept] = m_.triangles[i];
      m_.triangle_refs[kept++] = m_.triangle_refs[i];
    }
    m_.triangles.resize(kept), m_.triangle_refs.resize(kept);
    renumber_list(m_.required_triangles, new_index);
    add_missing(there);
  }

  /// Of a face of a flat tet that is no more: what takes its place gets its reference.
  void remember_ref(const Triangle& triangle, std::int32_t ref) {
    for (std::size_t i = 0; i < flat_.size(); ++i) {
      const Tet& t = flat_[i];
      const bool has = std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) {
        return std::find(t.begin(), t.end(), v) != t.end();
      });
      if (has) flat_refs_.try_emplace(i, ref);
    }
  }

  /// That of what was there, or of the triangles beside it in the same plane, where these agree; else 0.
  std::int32_t ref_of_missing(const Triangle& triangle) const {
    for (const auto& [i, ref] : flat_refs_) {
      const Tet& t = flat_[i];
      if (std::all_of(triangle.begin(), triangle.end(),
                      [&](std::uint32_t v) { return std::find(t.begin(), t.end(), v) != t.end(); }))
        return ref;
    }
    std::set<std::int32_t> refs;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [begin, end] = beside_.equal_range(in_order(std::array{triangle[k], triangle[(k + 1) % 3]}));
      for (auto at = begin; at != end; ++at) {
        const Triangle& other = m_.triangles[at->second];
        const bool in_plane = std::all_of(other.begin(), other.end(), [&](std::uint32_t v) {
          return orientation(m_.points[triangle[0]], m_.points[triangle[1]], m_.points[triangle[2]],
                             m_.points[v]) == 0;
        });
        if (in_plane) refs.insert(m_.triangle_refs[at->second]);
      }
    }
    return refs.size() == 1 ? *refs.begin() : 0;
  }

  /// Of the boundary, and between tets of different references.
  void add_missing(const std::map<Triangle, std::uint32_t>& there) {
    for (std::uint32_t i = 0; i < m_.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        beside_.emplace(in_order(std::array{m_.triangles[i][k], m_.triangles[i][(k + 1) % 3]}), i);
    const Adjacency adjacency = build_adjacency(m_.tets, m_.points.size());
    for (std::uint32_t t = 0; t < m_.tets.size(); ++t)
      for (int f = 0; f < 4; ++f) {
        const std::uint32_t n = adjacency.neighbours[t][f];
        if (n != kNoNeighbour && (m_.tet_refs[n >> 2] == m_.tet_refs[t] || n >> 2 < t)) continue;
        const Triangle face = face_of(m_.tets[t], f);
        if (there.contains(in_order(face))) continue;
        m_.triangles.push_back({face[0], face[2], face[1]});
        m_.triangle_refs.push_back(ref_of_missing(face));
        mend("missing triangles made", "tet").add(tet_source_[t]);
      }
  }

  void mend_edges() {
    std::vector<std::uint32_t> new_index(m_.edges.size(), kGone);
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> there;  // by their new numbers
    std::vector<bool> used(m_.points.size());
    for (const auto& t : m_.tets)
      for (const std::uint32_t v : t) used[v] = true;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < m_.edges.size(); ++i) {
      const auto& e = m_.edges[i];
      bool good = e[0] != e[1] && e[0] < used.size() && e[1] < used.size() && used[e[0]] && used[e[1]];
      if (good) {
        const auto [known, is_new] = there.try_emplace(in_order(e), static_cast<std::uint32_t>(kept));
        new_index[i] = known->second;  // what stays is a ridge, or required, if one of them was
        good = is_new;
      }
      if (!good) {
        mend("edges that are repeated, or of no tets, removed", "edge").add(edge_source_[i]);
        continue;
      }
      m_.edges[kept] = e;
      m_.edge_refs[kept++] = m_.edge_refs[i];
    }
    m_.edges.resize(kept), m_.edge_refs.resize(kept);
    renumber_list(m_.ridges, new_index);
    renumber_list(m_.required_edges, new_index);
  }

  static void renumber_list(std::vector<std::uint32_t>& list, const std::vector<std::uint32_t>& new_index) {
    std::set<std::uint32_t> there;
    for (const std::uint32_t i : list)
      if (i < new_index.size() && new_index[i] != kGone) there.insert(new_index[i]);
    list.assign(there.begin(), there.end());
  }

  MeshData& m_;
  std::vector<std::uint32_t> tet_source_;                     ///< of each tet: its number in the input
  std::vector<std::uint32_t> triangle_source_, edge_source_;  ///< until their turn comes
  std::set<std::uint32_t> against_neighbours_;  ///< as read: tets that had volume, and had to be turned
  std::vector<Tet> flat_;                       ///< those that were removed
  std::map<std::size_t, std::int32_t> flat_refs_;
  std::multimap<std::array<std::uint32_t, 2>, std::uint32_t> beside_;  ///< edge -> listed triangles
  MeshRepair result_;
};

}  // namespace

void MeshMend::add(std::uint64_t index, double change) {
  constexpr std::size_t kMostExamples = 5;
  ++count;
  if (examples.size() < kMostExamples) examples.push_back(index + 1);
  amount = std::max(amount, change);
}

MeshRepair repair_mesh(MeshData& mesh) { return Repair(mesh).run(); }

}  // namespace weft::meshing
