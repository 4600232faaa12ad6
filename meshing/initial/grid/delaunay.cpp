// Points come in random rounds of growing size, each along a space-filling curve (Amenta, Choi, Rote 2003).
#include "meshing/initial/grid/delaunay.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "meshing/base/box.h"
#include "meshing/base/morton.h"
#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

std::uint64_t morton_code(const Point& p, const Box& box) {
  std::uint64_t code = 0;
  for (int i = 0; i < 3; ++i) {
    const double size = box.hi[i] - box.lo[i];
    const double at = size > 0 ? (p[i] - box.lo[i]) / size : 0;
    code |= spread_bits(static_cast<std::uint64_t>(at * 2097151.0)) << i;
  }
  return code;
}

std::vector<std::uint32_t> insertion_order(std::span<const Point> points, const Box& box) {
  struct Key {
    int round;
    std::uint64_t code;
    std::uint32_t index;
  };
  std::mt19937 random(1);
  std::vector<Key> keys;
  keys.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    int round = 0;
    while (round < 20 && (random() & 1u)) ++round;
    keys.push_back({-round, morton_code(points[i], box), i});
  }
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return std::tie(a.round, a.code, a.index) < std::tie(b.round, b.code, b.index);
  });
  std::vector<std::uint32_t> order;
  order.reserve(keys.size());
  for (const Key& k : keys) order.push_back(k.index);
  return order;
}

/// Walks, digs, fills: one point at a time.
class Insertion {
 public:
  explicit Insertion(TetGrid& grid) : grid_(grid) {}

  void insert(std::uint32_t v) {
    dig(locate(v), v);
    grid_.star(cavity_, v, fresh_);
    last_ = grid_.fill_star(cavity_, fresh_).front();
  }

 private:
  /// The tet that holds the point: through any face that has it on its other side (ends, because the grid is
  /// Delaunay).
  std::uint32_t locate(std::uint32_t v) const {
    std::uint32_t t = last_;
    for (int f = 0; f < 4;) {
      const Face3 w = grid_.face(t, f);
      if (grid_.orient(w[0], w[1], w[2], v) >= 0) {
        ++f;
        continue;
      }
      t = grid_.tets[t].n[f] >> 2;
      f = 0;
    }
    return t;
  }

  bool conflicts(std::uint32_t t, std::uint32_t v) const {
    const Tet4& w = grid_.tets[t].v;
    const auto& p = grid_.points;
    return in_sphere(p[w[0]], p[w[1]], p[w[2]], p[w[3]], p[v]) > 0;
  }

  /// All tets whose circumsphere holds the point strictly: they are connected and star-shaped, even where
  /// points are cospherical.
  void dig(std::uint32_t start, std::uint32_t v) {
    seen_.resize(grid_.tets.size(), kNothing);
    cavity_.assign(1, start);
    seen_[start] = v;
    for (std::size_t i = 0; i < cavity_.size(); ++i)
      for (const std::uint32_t n : Tet4(grid_.tets[cavity_[i]].n)) {
        if (n == kNothing || seen_[n >> 2] == v) continue;
        seen_[n >> 2] = v;
        if (conflicts(n >> 2, v)) cavity_.push_back(n >> 2);
      }
  }

  TetGrid& grid_;
  std::uint32_t last_ = 0;
  std::vector<std::uint32_t> cavity_, seen_;
  std::vector<Tet4> fresh_;
};

/// Six tets around the box's diagonal from its first to its last corner.
void add_box(TetGrid& grid, const Box& inner) {
  const Vec size = inner.size();
  const double margin = std::max({size.x, size.y, size.z});
  const auto first = static_cast<std::uint32_t>(grid.points.size());
  for (int i = 0; i < 8; ++i)
    grid.add_point({i & 1 ? inner.hi.x + margin : inner.lo.x - margin,
                    i & 2 ? inner.hi.y + margin : inner.lo.y - margin,
                    i & 4 ? inner.hi.z + margin : inner.lo.z - margin});
  constexpr std::array<std::array<std::uint32_t, 2>, 6> paths = {
      {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}}};
  std::vector<Tet4> tets;
  for (const auto& p : paths) tets.push_back({first, first + p[0], first + p[1], first + 7});
  for (Tet4& t : tets)
    if (!grid.positive(t)) std::swap(t[0], t[1]);
  grid.replace({}, tets);
}

}  // namespace

TetGrid delaunay_in_box(std::span<const Point> points, const std::atomic<bool>* interrupt) {
  TetGrid grid;
  grid.interrupt = interrupt;
  Box box;
  for (const Point& p : points) {
    box.include(p);
    grid.add_point(p);
  }
  add_box(grid, box);
  Insertion insertion(grid);
  for (const std::uint32_t v : insertion_order(points, box)) insertion.insert(v);
  return grid;
}

}  // namespace weft::meshing
