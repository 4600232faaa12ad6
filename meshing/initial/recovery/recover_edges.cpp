// Input edges become grid edges: by flips, else by Steiner points where the edge pierces grid faces (George,
// Borouchaki and Saltel 2003).
#include "meshing/initial/recovery/recover_edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "meshing/initial/recovery/insert_steiner.h"
#include "meshing/initial/recovery/relax_steiner.h"
#include "meshing/initial/recovery/remove_edge.h"

namespace weft::meshing {

void list_input_edges(Recovery& r) {
  std::unordered_map<std::uint64_t, std::uint32_t> index;
  r.facet_edges.resize(r.facets.size());
  for (std::size_t f = 0; f < r.facets.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = r.facets[f][i], b = r.facets[f][(i + 1) % 3];
      const auto [at, is_new] =
          index.try_emplace(Recovery::key(a, b), static_cast<std::uint32_t>(r.edges.size()));
      if (is_new) r.edges.push_back({a, b, {}});
      r.facet_edges[f][i] = at->second;
    }
}

namespace {

/// A grid face, or (z == kNothing) a grid edge, that the way from s to t goes through.
struct Obstacle {
  std::uint32_t x, y, z;
  std::uint32_t tet;  ///< on the near side
};

class EdgeRecovery {
 public:
  explicit EdgeRecovery(Recovery& r) : r_(r), grid_(r.grid) {}

  void run() {
    for (std::uint32_t e = 0; e < r_.edges.size(); ++e) recover(e);
  }

 private:
  static constexpr std::size_t kMostPoints = 10000;  ///< on one edge: beyond, rounding leads in circles

  void recover(std::uint32_t e) {
    edge_ = e;
    std::vector<std::uint32_t> targets = {r_.edges[e].b};
    std::uint32_t at = r_.edges[e].a;
    while (!targets.empty()) {
      const std::uint32_t next = targets.back();
      if (!reach(at, next)) {
        if (targets.size() + r_.edges[e].chain.size() > kMostPoints) fail();
        targets.push_back(add_steiner(e, at, next));
        continue;
      }
      r_.edge_at[Recovery::key(at, next)] = e;
      targets.pop_back();
      if (!targets.empty()) r_.edges[e].chain.push_back(next);
      at = next;
    }
  }

  /// Makes (s, t) a grid edge if flips can. Every flip leaves fewer obstacles.
  bool reach(std::uint32_t s, std::uint32_t t) {
    for (;;) {
      if (grid_.tet_with_edge(s, t) != kNothing) return true;
      trace(s, t);
      if (!flip_one(s, t)) return false;
    }
  }

  int side(std::uint32_t u, std::uint32_t v) const { return grid_.orient(s_, t_, u, v); }

  /// Lists the obstacles from s to t, at most up to the first edge that is hit.
  void trace(std::uint32_t s, std::uint32_t t) {
    s_ = s, t_ = t;
    obstacles_.clear();
    start();
    while (obstacles_.back().z != kNothing && advance()) {
    }
  }

  void start() {
    grid_.ball(s_, ball_);
    for (const std::uint32_t tet : ball_) {
      const Face3 w = grid_.face(tet, grid_.local_index(tet, s_));
      const std::array<int, 3> o = {side(w[0], w[1]), side(w[1], w[2]), side(w[2], w[0])};
      if (o[0] > 0 || o[1] > 0 || o[2] > 0) continue;
      const auto zeros = std::count(o.begin(), o.end(), 0);
      if (zeros > 1) throw_touching(o[0] != 0 ? w[2] : o[1] != 0 ? w[0] : w[1]);
      if (zeros == 0) return obstacles_.push_back({w[0], w[1], w[2], tet});
      const std::size_t i = static_cast<std::size_t>(std::find(o.begin(), o.end(), 0) - o.begin());
      return obstacles_.push_back({w[i], w[(i + 1) % 3], kNothing, tet});
    }
    fail();
  }

  /// The next obstacle beyond the last one, a face; false when t is the apex there.
  bool advance() {
    const Obstacle from = obstacles_.back();
    const std::uint32_t tet = beyond(from);
    std::uint32_t d = 0;
    for (const std::uint32_t v : grid_.tets[tet].v)
      if (v != from.x && v != from.y && v != from.z) d = v;
    if (d == t_) return false;
    if (obstacles_.size() > grid_.tets.size()) fail();
    const std::array<std::uint32_t, 3> w = {from.x, from.y, from.z};
    std::array<int, 3> o;
    for (std::size_t i = 0; i < 3; ++i) o[i] = side(w[i], d);
    if (std::count(o.begin(), o.end(), 0) > 1) throw_touching(d);
    for (std::size_t i = 0; i < 3; ++i)
      if (o[i] == 0 && leaves_by_edge(d, w[(i + 1) % 3], w[(i + 2) % 3])) {
        obstacles_.push_back({w[i], d, kNothing, tet});
        return true;
      }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      if (o[j] <= 0 && o[i] >= 0) {
        obstacles_.push_back({w[i], w[j], d, tet});
        return true;
      }
    }
    fail();
  }

  /// The way lies in the plane of edge (u, d): it leaves through that edge or through the face without u.
  bool leaves_by_edge(std::uint32_t d, std::uint32_t v, std::uint32_t w) const {
    return side(v, d) < 0 && side(w, d) > 0;
  }

  std::uint32_t beyond(const Obstacle& o) const {
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t v = grid_.tets[o.tet].v[f];
      if (v != o.x && v != o.y && v != o.z) return grid_.tets[o.tet].n[f] >> 2;
    }
    return kNothing;
  }

  bool flip_one(std::uint32_t s, std::uint32_t t) {
    for (const Obstacle& o : obstacles_)
      if (o.z != kNothing && flip_face(o)) return true;
    const std::vector<Obstacle> obstacles = obstacles_;
    for (const Obstacle& o : obstacles) {
      if (remove(s, t, o.x, o.y)) return true;
      if (o.z != kNothing && (remove(s, t, o.y, o.z) || remove(s, t, o.z, o.x))) return true;
    }
    return false;
  }

  /// Two tets become three around the edge between their apexes, where that takes an obstacle away.
  bool flip_face(const Obstacle& o) {
    const std::uint32_t far = beyond(o);
    const auto apex = [&](std::uint32_t tet) {
      for (const std::uint32_t v : grid_.tets[tet].v)
        if (v != o.x && v != o.y && v != o.z) return v;
      return kNothing;
    };
    const std::uint32_t p = apex(o.tet), q = apex(far);
    const Face3 w = grid_.face(o.tet, grid_.local_index(o.tet, p));
    std::array<Tet4, 3> fresh;
    int crossed = 0, slivers = -grid_.sliver(grid_.tets[o.tet].v) - grid_.sliver(grid_.tets[far].v);
    for (std::size_t i = 0; i < 3; ++i) {
      fresh[i] = {w[i], w[(i + 1) % 3], q, p};
      if (!grid_.positive(fresh[i])) return false;
      slivers += grid_.sliver(fresh[i]);
      crossed += crosses(w[i], p, q);
    }
    if (crossed > 0 || slivers > 0) return false;
    const std::array<std::uint32_t, 2> old = {o.tet, far};
    grid_.replace(old, fresh);
    ++r_.flips;
    return true;
  }

  bool remove(std::uint32_t s, std::uint32_t t, std::uint32_t u, std::uint32_t v) {
    if (u == s || u == t || v == s || v == t) return false;
    const std::uint32_t tet = grid_.tet_with_edge(u, v);
    grid_.shell(tet, u, v, shell_);
    int now = r_.sliver_cost(shell_.tets);
    for (const std::uint32_t w : shell_.ring) now += crosses(u, v, w);
    return remove_edge(
        r_, u, v, now,
        [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
          return r_.sliver_cost({a, b, c, v}) + r_.sliver_cost({b, a, c, u}) + crosses(a, b, c);
        },
        [&](std::uint32_t a, std::uint32_t b) { return crosses(a, b, u) + crosses(a, b, v); });
  }

  /// Whether the way from s to t meets the closed face.
  int crosses(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    for (const std::uint32_t v : {x, y, z})
      if (v == s_ || v == t_) return 0;
    if (grid_.orient(x, y, z, s_) * grid_.orient(x, y, z, t_) > 0) return 0;
    const int a = side(x, y), b = side(y, z), c = side(z, x);
    return (a <= 0 && b <= 0 && c <= 0) || (a >= 0 && b >= 0 && c >= 0);
  }

  /// A Steiner point at the obstacle nearest to the middle of the way that takes one.
  std::uint32_t add_steiner(std::uint32_t e, std::uint32_t s, std::uint32_t t) {
    trace(s, t);
    std::vector<std::pair<double, const Obstacle*>> choice;
    for (const Obstacle& o : obstacles_) choice.emplace_back(std::abs(place(o) - 0.5), &o);
    std::sort(choice.begin(), choice.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    const std::uint32_t v = grid_.add_point({});
    r_.steiner.push_back({v, e, kNothing});
    for (const auto& [x, obstacle] : choice) {
      grid_.place_exactly(v, meeting(e, *obstacle));
      if (!insert(*obstacle, v)) continue;
      relax_on_edge(r_, v, s == r_.edges[e].a ? 0 : grid_.place(s).s.terms[0],
                    t == r_.edges[e].b ? 1 : grid_.place(t).s.terms[0]);
      return v;
    }
    fail();
  }

  /// About where on the way the obstacle is, in (0, 1).
  double place(const Obstacle& o) const {
    const auto& p = grid_.points;
    const std::uint32_t z = third(o);
    const double ds = six_volume(p[o.x], p[o.y], p[z], p[s_]), dt = six_volume(p[o.x], p[o.y], p[z], p[t_]);
    return ds == dt ? 0.5 : std::clamp(ds / (ds - dt), 0.0, 1.0);
  }

  /// A vertex that makes a face of the obstacle, off the plane that an edge and the way are in.
  std::uint32_t third(const Obstacle& o) const {
    if (o.z != kNothing) return o.z;
    for (const std::uint32_t v : grid_.tets[o.tet].v)
      if (v != o.x && v != o.y && grid_.orient(o.x, o.y, v, s_) != 0) return v;
    return kNothing;
  }

  /// Where the input edge meets the obstacle.
  ExactPlace meeting(std::uint32_t e, const Obstacle& o) const {
    return place_on_edge(grid_.points[r_.edges[e].a], grid_.points[r_.edges[e].b],
                         {grid_.place(o.x), grid_.place(o.y), grid_.place(third(o))});
  }

  bool insert(const Obstacle& o, std::uint32_t v) {
    if (o.z != kNothing) {
      const std::array<std::uint32_t, 2> pair = {o.tet, beyond(o)};
      if (insert_steiner(r_, pair, v)) return true;
    }
    const std::array<std::array<std::uint32_t, 2>, 3> edges = {{{o.x, o.y}, {o.y, o.z}, {o.z, o.x}}};
    for (std::size_t i = 0; i < (o.z == kNothing ? 1u : 3u); ++i) {
      if (r_.edge_at.contains(Recovery::key(edges[i][0], edges[i][1]))) continue;
      grid_.shell(o.tet, edges[i][0], edges[i][1], shell_);
      if (insert_steiner(r_, shell_.tets, v)) return true;
    }
    return false;
  }

  [[noreturn]] void throw_touching(std::uint32_t v) const {
    const Point& p = grid_.points[v];
    r_.refuse_edge(edge_,
                   fmt::format("passes through another vertex, at ({:.6g}, {:.6g}, {:.6g})", p.x, p.y, p.z));
  }
  [[noreturn]] void fail() const { r_.refuse_edge(edge_, Recovery::kTooThin); }

  Recovery& r_;
  TetGrid& grid_;
  std::uint32_t edge_ = 0, s_ = 0, t_ = 0;
  std::vector<Obstacle> obstacles_;
  std::vector<std::uint32_t> ball_;
  TetGrid::EdgeShell shell_;
};

}  // namespace

void recover_edges(Recovery& r) { EdgeRecovery(r).run(); }

}  // namespace weft::meshing
