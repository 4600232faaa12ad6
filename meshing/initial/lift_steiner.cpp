// Steiner points leave the surface: each side gets its own copy, pushed into the tets there (George,
// Borouchaki and Saltel 2003). What the link of the point sees of it, it also sees of a point near it.
#include <algorithm>
#include <cmath>
#include <map>

#include "meshing/initial/recovery.h"
#include "meshing/predicates.h"

namespace weft::meshing {
namespace {

/// The faces of one facet around the point, opened to a polygon that is to be triangulated without it.
struct Opening {
  std::uint32_t facet;
  std::vector<std::uint32_t> polygon;  ///< in the facet's own order
  std::vector<Face3> triangles;
};

/// The tets on one side of the facets around the point.
struct Side {
  std::vector<std::uint32_t> tets;
  std::vector<Tet4> fresh;         ///< with the point still as it was
  std::uint32_t into = kNothing;   ///< the vertex of the link that takes the point's place, if one does
  Point place;                     ///< else where the copy goes
};

class Lift {
 public:
  explicit Lift(Recovery& r) : r_(r), grid_(r.grid) {}

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
    for (Side& side : sides_)
      if (!make_side(side) || !find_best(side)) return false;
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
      sides_.push_back({{first}, {}, kNothing, {}});
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

  /// The side's own tets and one on each triangle of the facets that bound it.
  bool make_side(Side& side) {
    side.fresh.clear();
    std::map<std::uint32_t, bool> bounds;  // facet -> whether the side is on its positive side
    for (const std::uint32_t t : side.tets) {
      side.fresh.push_back(grid_.tets[t].v);
      for (int f = 0; f < 4; ++f) {
        const std::uint32_t facet = grid_.tets[t].facet[f];
        if (facet == kNothing || grid_.tets[t].v[f] == v_) continue;
        const Face3 w = grid_.face(t, f);
        const auto [x, y] = ordered(w, facet);
        const bool above = face_turns(w, x, y);
        const auto [at, is_new] = bounds.try_emplace(facet, above);
        if (!is_new && at->second != above) return false;  // both sides of one facet: nothing to separate
      }
    }
    for (const auto& [facet, above] : bounds)
      for (const Opening& o : openings_)
        if (o.facet == facet)
          for (const auto& [a, b, c] : o.triangles)
            side.fresh.push_back(above ? Tet4{a, b, c, v_} : Tet4{b, a, c, v_});
    return true;
  }

  /// Whether the face, seen with its tet on the positive side, goes from v to x to y.
  bool face_turns(const Face3& w, std::uint32_t x, std::uint32_t y) const {
    const auto i = static_cast<std::size_t>(std::find(w.begin(), w.end(), x) - w.begin());
    return w[(i + 1) % 3] == y;
  }

  /// A vertex of the link, where its worst tet is no worse than a copy's would be: copies under copies would
  /// come ever nearer to the surface.
  bool find_best(Side& side) {
    const double merged = find_neighbour(side);
    const double moved = find_place(side);
    if (merged < moved) side.into = kNothing;
    return std::max(merged, moved) > 0;
  }

  double find_neighbour(Side& side) const {
    std::vector<std::uint32_t> link;
    for (const std::uint32_t t : side.tets)
      for (const std::uint32_t v : grid_.tets[t].v)
        if (v != v_) link.push_back(v);
    std::sort(link.begin(), link.end());
    link.erase(std::unique(link.begin(), link.end()), link.end());
    double best = 0;
    for (const std::uint32_t w : link) {
      const double shape = worst_from(side, w, best);
      if (shape <= best) continue;
      best = shape;
      side.into = w;
    }
    return best;
  }

  /// The worst shape with w in the place of the point; 0 where it is not above `enough`.
  double worst_from(const Side& side, std::uint32_t w, double enough) const {
    double worst = 1;
    for (Tet4 t : side.fresh) {
      if (std::find(t.begin(), t.end(), w) != t.end()) continue;
      std::replace(t.begin(), t.end(), v_, w);
      worst = std::min(worst, grid_.shape(t));
      if (worst <= enough) return 0;
    }
    return worst;
  }

  /// Halves the way from points well inside to where the point is now, and takes the best place seen.
  double find_place(Side& side) {
    const ExactPlace exactly = grid_.place(v_);
    const Point start = grid_.points[v_];
    double best = 0;
    for (const Vec& way : ways(side))
      for (double step = 1; step > 1e-9; step *= 0.5) {
        grid_.move(v_, start + step * way);
        const double q = worst_shape(side);
        if (q <= best) continue;
        best = q;
        side.place = grid_.points[v_];
      }
    grid_.place_exactly(v_, exactly);
    return best;
  }

  /// To the middle of the link, and along the mean of the facets' normals.
  std::vector<Vec> ways(const Side& side) const {
    const Point& p = grid_.points[v_];
    Vec middle, normals;
    double count = 0, length = 0;
    for (const Tet4& t : side.fresh)
      for (int i = 0; i < 4; ++i) {
        if (t[i] == v_) continue;
        const Vec d = grid_.points[t[i]] - p;
        middle += d;
        length += norm(d);
        ++count;
      }
    for (std::size_t i = side.tets.size(); i < side.fresh.size(); ++i) {
      const Tet4& t = side.fresh[i];
      const Vec n = cross(grid_.points[t[1]] - grid_.points[t[0]], grid_.points[t[2]] - grid_.points[t[0]]);
      if (norm(n) > 0) normals += (1 / norm(n)) * n;
    }
    const double size = norm(normals);
    std::vector<Vec> result = {(1 / count) * middle};
    if (size > 0) result.push_back((length / count / size) * normals);
    if (size > 0) result.push_back(0.5 * (result[0] + result[1]));
    return result;
  }

  double worst_shape(const Side& side) const {
    double worst = 1;
    for (const Tet4& t : side.fresh)
      if (worst > 0) worst = std::min(worst, grid_.shape(t));
    return worst;
  }

  /// Every side gets a new vertex: faces that end at the old one are no part of the new tets.
  void commit() {
    std::vector<Tet4> fresh;
    std::vector<FacetFace> facets;
    for (const Side& side : sides_) {
      const std::uint32_t v = side.into != kNothing ? side.into : grid_.add_point(side.place);
      for (Tet4 t : side.fresh) {
        if (std::find(t.begin(), t.end(), v) != t.end()) continue;
        std::replace(t.begin(), t.end(), v_, v);
        fresh.push_back(t);
      }
    }
    for (const Opening& o : openings_)
      for (const Face3& t : o.triangles) facets.push_back({t, o.facet});
    grid_.replace(ball_, fresh, facets);
    grid_.vertex_tet[v_] = kNothing;
  }

  Recovery& r_;
  TetGrid& grid_;
  std::uint32_t v_ = 0;
  std::vector<std::uint32_t> ball_;
  std::vector<Opening> openings_;
  std::vector<Side> sides_;
};

}  // namespace

std::uint64_t lift_steiner_points(Recovery& r) { return Lift(r).run(); }

}  // namespace weft::meshing
