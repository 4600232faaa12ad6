// Steiner points leave the surface: each side gets its own copy, pushed into the tets there (George,
// Borouchaki and Saltel 2003). What the link of the point sees of it, it also sees of a point near it.
#include "meshing/initial/recovery/lift_steiner.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "meshing/initial/grid/star_cavity.h"

namespace weft::meshing {
namespace {

/// The faces of one facet around the point, opened to a polygon that is to be triangulated without it.
struct Opening {
  std::uint32_t facet;
  std::vector<std::uint32_t> polygon;  ///< in the facet's own order
  std::vector<Face3> triangles;
};

/// The tets on one side of the facets around the point, and what is to fill their place.
struct Side {
  std::vector<std::uint32_t> tets;
  std::vector<Face3> lids;  ///< triangles of the openings, seen from this side
  Star star;
  Point place;  ///< of the copy, if the star is around one
};

class Lift {
 public:
  explicit Lift(Recovery& r) : r_(r), grid_(r.grid), cavity_(r.grid) {}

  /// Points on edges first: then no three vertices of what opens around the others are on one line. Rounding
  /// may forbid a move until neighbours have gone.
  std::uint64_t run() {
    std::stable_partition(r_.steiner.begin(), r_.steiner.end(),
                          [](const SteinerPoint& p) { return p.edge != kNothing; });
    for (std::size_t before = r_.steiner.size() + 1; r_.steiner.size() < before;) {
      before = r_.steiner.size();
      std::erase_if(r_.steiner, [&](const SteinerPoint& p) { return lift(p.vertex); });
    }
    return r_.steiner.size();
  }

 private:
  bool lift(std::uint32_t v) {
    v_ = v;
    if (grid_.vertex_tet[v] == kNothing) return true;
    grid_.ball(v, ball_);
    if (!open_facets()) return false;
    find_sides();
    std::vector<std::uint32_t> blocked = ball_;
    for (Side& side : sides_) {
      if (!find_lids(side) || !find_star(side, blocked)) return false;
      blocked.insert(blocked.end(), side.star.old.begin(), side.star.old.end());
    }
    commit();
    return true;
  }

  bool open_facets() {
    std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>>
        next;  // facet, vertex -> the one after it
    for (const std::uint32_t t : ball_)
      for (int f = 0; f < 4; ++f) {
        const std::uint32_t facet = grid_.tets[t].facet[f];
        if (facet == kNothing || grid_.tets[t].v[f] == v_) continue;
        const auto [x, y] = ordered(grid_.face(t, f), facet);
        next[facet][x] = y;
      }
    openings_.clear();
    for (const auto& [facet, links] : next) {
      openings_.push_back({facet, polygon(links), {}});
      if (openings_.back().polygon.size() < 3 || !triangulate(openings_.back())) return false;
    }
    return !openings_.empty();
  }

  /// The two vertices of a face at the point, in the order in which the facet turns.
  std::pair<std::uint32_t, std::uint32_t> ordered(const Face3& face, std::uint32_t facet) const {
    const auto i = static_cast<std::size_t>(std::find(face.begin(), face.end(), v_) - face.begin());
    const std::uint32_t x = face[(i + 1) % 3], y = face[(i + 2) % 3];
    return grid_.orient(v_, x, y, r_.above(facet)) >= 0 ? std::pair{x, y} : std::pair{y, x};
  }

  /// Chains the links into a path or a cycle; empty where they are neither.
  static std::vector<std::uint32_t> polygon(const std::map<std::uint32_t, std::uint32_t>& links) {
    std::uint32_t first = links.begin()->first;
    for (const auto& [x, y] : links)
      if (std::none_of(links.begin(), links.end(), [&](const auto& l) { return l.second == x; })) first = x;
    std::vector<std::uint32_t> path = {first};
    for (auto at = links.find(first); at != links.end(); at = links.find(path.back())) {
      if (at->second == first) break;
      path.push_back(at->second);
      if (path.size() > links.size() + 1) return {};
    }
    const std::size_t closed = links.size(), open = links.size() + 1;
    return path.size() == closed || path.size() == open ? path : std::vector<std::uint32_t>{};
  }

  /// Area over squared edges of a triangle; 0 when it turns against the facet, whose positive side is that of
  /// `above`.
  double shape(const Opening& o, const Point& above, std::size_t i, std::size_t k, std::size_t j) const {
    if (grid_.orient(o.polygon[i], o.polygon[k], o.polygon[j], above) <= 0) return 0;
    const Point &a = grid_.points[o.polygon[i]], &b = grid_.points[o.polygon[k]],
                &c = grid_.points[o.polygon[j]];
    return std::max(norm(cross(b - a, c - a)) / (norm2(b - a) + norm2(c - b) + norm2(a - c)), 1e-300);
  }

  /// The triangulation whose worst triangle is best.
  bool triangulate(Opening& o) const {
    const std::size_t n = o.polygon.size();
    const Point above = r_.above(o.facet);
    std::vector<double> best(n * n, 1e300);
    std::vector<std::size_t> cut(n * n);
    for (std::size_t width = 2; width < n; ++width)
      for (std::size_t i = 0; i + width < n; ++i) {
        const std::size_t j = i + width;
        best[i * n + j] = 0;
        for (std::size_t k = i + 1; k < j; ++k) {
          const double worst = std::min({best[i * n + k], best[k * n + j], shape(o, above, i, k, j)});
          if (worst <= best[i * n + j]) continue;
          best[i * n + j] = worst;
          cut[i * n + j] = k;
        }
      }
    if (best[n - 1] <= 0) return false;
    collect(o, cut, 0, n - 1);
    return true;
  }

  static void collect(Opening& o, const std::vector<std::size_t>& cut, std::size_t i, std::size_t j) {
    if (j < i + 2) return;
    const std::size_t k = cut[i * o.polygon.size() + j];
    o.triangles.push_back({o.polygon[i], o.polygon[k], o.polygon[j]});
    collect(o, cut, i, k);
    collect(o, cut, k, j);
  }

  /// Parts of the ball that facets separate.
  void find_sides() {
    sides_.clear();
    std::map<std::uint32_t, bool> seen;
    for (const std::uint32_t t : ball_) seen[t] = false;
    for (const std::uint32_t first : ball_) {
      if (seen[first]) continue;
      seen[first] = true;
      sides_.push_back({{first}, {}, {}, {}});
      auto& tets = sides_.back().tets;
      for (std::size_t i = 0; i < tets.size(); ++i) {
        const TetGrid::Tet tet = grid_.tets[tets[i]];
        for (int f = 0; f < 4; ++f) {
          if (tet.n[f] == kNothing || tet.v[f] == v_ || tet.facet[f] != kNothing) continue;
          bool& there = seen[tet.n[f] >> 2];
          if (!there) tets.push_back(tet.n[f] >> 2);
          there = true;
        }
      }
    }
  }

  /// The triangles of the facets that bound the side; false where both sides of one do: nothing to separate.
  bool find_lids(Side& side) {
    std::map<std::uint32_t, bool> bounds;  // facet -> whether the side is on its positive side
    for (const std::uint32_t t : side.tets)
      for (int f = 0; f < 4; ++f) {
        const std::uint32_t facet = grid_.tets[t].facet[f];
        if (facet == kNothing || grid_.tets[t].v[f] == v_) continue;
        const Face3 w = grid_.face(t, f);
        const auto [x, y] = ordered(w, facet);
        const bool above = face_turns(w, x, y);
        const auto [at, is_new] = bounds.try_emplace(facet, above);
        if (!is_new && at->second != above) return false;
      }
    for (const auto& [facet, above] : bounds)
      for (const Opening& o : openings_)
        if (o.facet == facet)
          for (const auto& [a, b, c] : o.triangles)
            side.lids.push_back(above ? Face3{a, b, c} : Face3{b, a, c});
    return true;
  }

  /// Whether the face, seen with its tet on the positive side, goes from v to x to y.
  bool face_turns(const Face3& w, std::uint32_t x, std::uint32_t y) const {
    const auto i = static_cast<std::size_t>(std::find(w.begin(), w.end(), x) - w.begin());
    return w[(i + 1) % 3] == y;
  }

  /// Around a vertex of the link or a copy of the point, whichever makes better tets: copies alone would come
  /// ever nearer to the surface, one under the other.
  bool find_star(Side& side, std::span<const std::uint32_t> blocked) {
    cavity_.begin(v_, side.tets, side.lids, blocked);
    const std::vector<std::uint32_t> link = link_of(side);
    for (const std::uint32_t w : link) cavity_.improve(side.star, w);
    const ExactPlace exactly = grid_.place(v_);
    const Point start = grid_.points[v_];
    for (const Vec& way : ways(side, link))
      for (double step = 1; step > 1e-9; step *= 0.5) {
        grid_.move(v_, start + step * way);
        if (cavity_.improve(side.star, v_)) side.place = grid_.points[v_];
      }
    grid_.place_exactly(v_, exactly);
    return side.star.worst > 0;
  }

  std::vector<std::uint32_t> link_of(const Side& side) const {
    std::vector<std::uint32_t> link;
    for (const std::uint32_t t : side.tets)
      for (const std::uint32_t v : grid_.tets[t].v)
        if (v != v_) link.push_back(v);
    std::sort(link.begin(), link.end());
    link.erase(std::unique(link.begin(), link.end()), link.end());
    return link;
  }

  /// To the middle of the link, along the mean of the facets' normals, and between.
  std::vector<Vec> ways(const Side& side, const std::vector<std::uint32_t>& link) const {
    const double share = 1 / double(link.size());
    Vec middle, normals;
    double length = 0;
    for (const std::uint32_t w : link) {
      const Vec d = grid_.points[w] - grid_.points[v_];
      middle += share * d;
      length += share * norm(d);
    }
    for (const auto& [a, b, c] : side.lids) {
      const Vec n = cross(grid_.points[b] - grid_.points[a], grid_.points[c] - grid_.points[a]);
      if (norm(n) > 0) normals += (1 / norm(n)) * n;
    }
    std::vector<Vec> result = {middle};
    if (norm(normals) > 0) result.push_back((length / norm(normals)) * normals);
    if (norm(normals) > 0) result.push_back(0.5 * (result[0] + result[1]));
    return result;
  }

  /// Every side is filled: faces that end at the point are no part of the new tets. Sides that have grown may
  /// meet at other facets, which stay.
  void commit() {
    std::vector<FacetFace> facets;
    for (const Opening& o : openings_)
      for (const Face3& t : o.triangles) facets.push_back({t, o.facet});
    Star all;
    for (Side& side : sides_) {
      if (holds(side.star, v_)) replace_vertex(side.star, grid_.add_point(side.place));
      all.old.insert(all.old.end(), side.star.old.begin(), side.star.old.end());
      all.fresh.insert(all.fresh.end(), side.star.fresh.begin(), side.star.fresh.end());
    }
    list_facets_within(all.old, facets);
    fill(grid_, all, facets);
  }

  /// The faces of facets between two of the tets, but those that end at the point.
  void list_facets_within(std::vector<std::uint32_t> tets, std::vector<FacetFace>& facets) const {
    std::sort(tets.begin(), tets.end());
    for (const std::uint32_t t : tets)
      for (int f = 0; f < 4; ++f) {
        const std::uint32_t facet = grid_.tets[t].facet[f], n = grid_.tets[t].n[f];
        if (facet == kNothing || n == kNothing || !std::binary_search(tets.begin(), tets.end(), n >> 2))
          continue;
        const Face3 w = grid_.face(t, f);
        if (std::find(w.begin(), w.end(), v_) == w.end()) facets.push_back({w, facet});
      }
  }

  static bool holds(const Star& star, std::uint32_t v) { return star.fresh.front()[3] == v; }
  static void replace_vertex(Star& star, std::uint32_t v) {
    for (Tet4& t : star.fresh) t[3] = v;
  }

  Recovery& r_;
  TetGrid& grid_;
  std::uint32_t v_ = 0;
  std::vector<std::uint32_t> ball_;
  std::vector<Opening> openings_;
  std::vector<Side> sides_;
  StarCavity cavity_;
};

std::uint32_t facet_at(const Recovery& r, const std::vector<std::uint32_t>& ball) {
  for (const std::uint32_t t : ball)
    for (const std::uint32_t facet : r.grid.tets[t].facet)
      if (facet != kNothing) return facet;
  return kNothing;
}

}  // namespace

std::uint64_t lift_steiner_points(Recovery& r) { return Lift(r).run(); }

void round_steiner_points(Recovery& r) {
  std::vector<std::uint32_t> ball;
  for (const SteinerPoint& s : r.steiner) {
    r.grid.move(s.vertex, r.grid.points[s.vertex]);
    r.grid.ball(s.vertex, ball);
    for (const std::uint32_t t : ball)
      if (!r.grid.positive(r.grid.tets[t].v)) r.refuse_facet(facet_at(r, ball));
  }
}

}  // namespace weft::meshing
