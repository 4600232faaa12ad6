// An advancing front in a Delaunay grid (Rebay 1993): a point over a face of what is done, where the tet on
// it is nearly regular. Facets are walls, so the grid is Delaunay but for what they forbid. Threads have a
// front each, in a block whose tets at other blocks stay: so their points make one Delaunay grid.
#include "meshing/initial/inner_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "meshing/initial/grid/flip_to_delaunay.h"
#include "meshing/initial/grid/grid_block.h"

namespace weft::meshing {
namespace {

/// The centre of the circle through a triangle's corners where that is inside the triangle, else its
/// centroid.
Point middle_of(const Point& a, const Point& b, const Point& c) {
  const double ab = norm2(b - a), bc = norm2(c - b), ca = norm2(a - c);
  const double wa = bc * (ab + ca - bc), wb = ca * (ab + bc - ca), wc = ab * (bc + ca - ab);
  if (!(wa > 0 && wb > 0 && wc > 0)) return (1.0 / 3) * (a + b + c);
  return 1 / (wa + wb + wc) * (wa * a + wb * b + wc * c);
}

class Front {
 public:
  /// Sources stand at `origins`, by the vertices that they name. The grid's first `frozen` tets stay.
  Front(TetGrid& grid, std::span<const SizeSource> sources, const std::vector<Point>& origins,
        std::vector<SpreadSize> sizes, double largest, std::uint32_t frozen = 0)
      : grid_(grid),
        sources_(sources),
        origins_(origins),
        sizes_(std::move(sizes)),
        largest_(largest),
        frozen_(frozen) {
    spare_ = add_point();
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t)
      if (grid_.alive(t)) look_at(t);
  }

  /// The middles of what is empty come first: among the points of a round surface alone nearly all
  /// circumspheres are the same, and each new point would be connected to all others.
  void insert_far_apart(const std::atomic<bool>* interrupt) {
    nearest_ = kFarApart;
    most_tets_ = std::numeric_limits<std::size_t>::max();
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) enqueue_huge(t);
    while (!huge_.empty() && !(interrupt && *interrupt)) {
      const Huge huge = huge_.top();
      huge_.pop();
      if (!grid_.alive(huge.tet) || spheres_[huge.tet].radius2 != huge.radius2) continue;
      if (insert(huge.tet, spheres_[huge.tet].center))
        for (const std::uint32_t t : slots_) enqueue_huge(t);
    }
    nearest_ = kNearest;
    most_tets_ = kMostTets;
  }

  void advance(const std::atomic<bool>* interrupt) {
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) enqueue(t);
    for (std::size_t i = 0; i < queue_.size() && !(interrupt && *interrupt); ++i) advance_from(queue_[i]);
  }

  /// What is known at the end, by vertices and by tets.
  struct State {
    std::vector<SpreadSize> sizes;
    std::vector<char> large;  ///< and something may still be done about it
  };
  State take_state() { return {std::move(sizes_), std::move(large_)}; }
  void set_large(std::vector<char> large) { large_ = std::move(large); }

 private:
  struct Sphere {
    Point center;
    double radius2;  ///< infinite for a flat tet
  };
  // Shares of the size.
  static constexpr double kLargeRadius = 0.8;  ///< of a tet that is broken up; a regular one has 0.61
  static constexpr double kNearest = 0.7;      ///< of a new point to any other
  static constexpr double kFarApart = 2;       ///< of the first points
  static constexpr double kFlattest = 0.5;     ///< height of a new point over the face it is made for
  /// What a point may break up, once those far apart stand: round a corner many tets have circumspheres with
  /// the point, and hide behind each other.
  static constexpr std::size_t kMostTets = 200;
  static constexpr double kOverFacet = 0.35;  ///< least height over facets

  /// A tet whose circumcentre is far from everything.
  struct Huge {
    double radius2;
    std::uint32_t tet;
    bool operator<(const Huge& other) const {
      return radius2 != other.radius2 ? radius2 < other.radius2 : tet > other.tet;
    }
  };

  void enqueue_huge(std::uint32_t t) {
    if (!grid_.alive(t) || !large_[t] || !std::isfinite(spheres_[t].radius2)) return;
    const double radius = std::sqrt(spheres_[t].radius2);
    double wanted = largest_;
    for (const std::uint32_t v : grid_.tets[t].v)
      wanted = std::min(wanted, size_from(v, spheres_[t].center).size);
    if (radius > kFarApart * wanted) huge_.push({spheres_[t].radius2, t});
  }

  std::uint32_t add_point() {
    sizes_.resize(grid_.points.size() + 1);
    return grid_.add_point({});
  }

  double size(std::uint32_t v) const { return std::min(sizes_[v].size, largest_); }

  SpreadSize size_from(std::uint32_t v, const Point& p) const {
    const SizeSource& source = sources_[sizes_[v].source];
    return spread_on(sizes_[v], source, origins_[source.vertex], norm(p - grid_.points[v]), p);
  }

  /// Notes the tet's circumsphere and whether it is too large.
  void look_at(std::uint32_t t) {
    if (spheres_.size() < grid_.tets.size()) {
      spheres_.resize(grid_.tets.size());
      large_.resize(grid_.tets.size());
    }
    const Tet4& v = grid_.tets[t].v;
    const Point& a = grid_.points[v[0]];
    const Vec x = grid_.points[v[1]] - a, y = grid_.points[v[2]] - a, z = grid_.points[v[3]] - a;
    const Vec yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
    const Vec to = 0.5 / dot(x, yz) * (norm2(x) * yz + norm2(y) * zx + norm2(z) * xy);
    const double radius2 = norm2(to);
    const bool flat = !(radius2 < 1e30 * norm2(x));
    spheres_[t] = {a + to, flat ? std::numeric_limits<double>::infinity() : radius2};
    const double wanted = kLargeRadius * 0.25 * (size(v[0]) + size(v[1]) + size(v[2]) + size(v[3]));
    large_[t] = !(radius2 < wanted * wanted);
  }

  bool is_front(std::uint32_t t, int f) const {
    const TetGrid::Tet& tet = grid_.tets[t];
    return tet.facet[f] != kNothing || tet.n[f] == kNothing || !large_[tet.n[f] >> 2];
  }

  void enqueue(std::uint32_t t) {
    if (t < frozen_ || !grid_.alive(t) || !large_[t]) return;
    for (int f = 0; f < 4; ++f)
      if (is_front(t, f)) return queue_.push_back(t);
  }

  void enqueue_beside(std::uint32_t t) {
    for (int f = 0; f < 4; ++f)
      if (grid_.tets[t].facet[f] == kNothing && grid_.tets[t].n[f] != kNothing)
        enqueue(grid_.tets[t].n[f] >> 2);
  }

  void enqueue_around() {
    for (const std::uint32_t t : slots_)
      if (large_[t])
        enqueue(t);
      else
        enqueue_beside(t);
  }

  void advance_from(std::uint32_t t) {
    if (!grid_.alive(t) || !large_[t]) return;
    meets_frozen_ = false;
    for (int f = 0; f < 4; ++f)
      if (is_front(t, f) && insert_over(t, f)) return enqueue_around();
    if (meets_frozen_) return;
    large_[t] = false;  // nothing can be done with it here
    enqueue_beside(t);
  }

  bool insert_over(std::uint32_t t, int f) {
    const Face3 w = grid_.face(t, f);
    const Point &a = grid_.points[w[0]], &b = grid_.points[w[1]], &c = grid_.points[w[2]];
    Vec normal = cross(b - a, c - a);
    const double twice_area = norm(normal);
    if (!(twice_area > 0)) return false;
    normal = 1 / twice_area * normal;
    const Point foot = middle_of(a, b, c);
    const double radius2 = std::max({norm2(a - foot), norm2(b - foot), norm2(c - foot)});
    const auto height = [&](double h) {
      return std::sqrt(std::max(h * h - radius2, kFlattest * kFlattest * h * h));
    };
    const double first = (size(w[0]) + size(w[1]) + size(w[2])) / 3;
    const Point guess = foot + height(first) * normal;
    double h = largest_;
    for (const std::uint32_t v : w) h = std::min(h, size_from(v, guess).size);
    double up = height(h);
    const Sphere& sphere = spheres_[t];
    if (std::isfinite(sphere.radius2)) {
      const double to_center = dot(sphere.center - foot, normal);
      if (to_center > 0 && up > to_center) return insert(t, sphere.center);
      if (!(norm2(foot + up * normal - sphere.center) < sphere.radius2)) return false;
    }
    return insert(t, foot + up * normal);
  }

  bool insert(std::uint32_t t, const Point& p) {
    grid_.points[spare_] = p;
    excluded_.clear();
    constexpr int kMostTries = 8;
    std::size_t looked_at = 0;
    for (int i = 0; i < kMostTries && looked_at < kMostTets; ++i) {
      dig(t, p);
      if (cavity_.back() < frozen_ || cavity_.size() > most_tets_) return false;
      if (grid_.star(cavity_, spare_, fresh_)) return is_well_placed(p) && fill();
      if (!exclude_hidden(t)) return false;
      looked_at += cavity_.size();
    }
    return false;
  }

  void dig(std::uint32_t start, const Point& p) {
    seen_.resize(grid_.tets.size(), 0);
    ++stamp_;
    for (const std::uint32_t t : excluded_) seen_[t] = stamp_;
    cavity_.assign(1, start);
    seen_[start] = stamp_;
    for (std::size_t i = 0; i < cavity_.size() && cavity_.size() <= most_tets_; ++i) {
      const TetGrid::Tet& tet = grid_.tets[cavity_[i]];
      for (int f = 0; f < 4; ++f) {
        if (tet.n[f] == kNothing || tet.facet[f] != kNothing) continue;
        const std::uint32_t n = tet.n[f] >> 2;
        if (seen_[n] == stamp_) continue;
        seen_[n] = stamp_;
        if (norm2(p - spheres_[n].center) < spheres_[n].radius2 * (1 - 1e-10) ||
            !std::isfinite(spheres_[n].radius2)) {
          cavity_.push_back(n);
          if (n < frozen_) return void(meets_frozen_ = true);
        }
      }
    }
  }

  /// Leaves out a tet whose outer face the point does not see: the last one that star() has looked at.
  bool exclude_hidden(std::uint32_t start) {
    for (const std::uint32_t t : cavity_) {
      for (int f = 0; f < 4; ++f) {
        const Face3 w = grid_.face(t, f);
        if (w[0] != fresh_.back()[0] || w[1] != fresh_.back()[1] || w[2] != fresh_.back()[2]) continue;
        if (t == start) return false;
        excluded_.push_back(t);
        return true;
      }
    }
    return false;
  }

  /// Far enough from what is there. Sets its size.
  bool is_well_placed(const Point& p) {
    SpreadSize best{std::numeric_limits<double>::infinity(), 0, 0};
    double nearest2 = std::numeric_limits<double>::infinity();
    ++vertex_stamp_;
    vertex_seen_.resize(grid_.points.size(), 0);
    for (const Tet4& t : fresh_)
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t v = t[i];
        if (vertex_seen_[v] == vertex_stamp_) continue;
        vertex_seen_[v] = vertex_stamp_;
        nearest2 = std::min(nearest2, norm2(p - grid_.points[v]));
        const SpreadSize here = size_from(v, p);
        if (here.size < best.size) best = here;
      }
    const double h = std::min(best.size, largest_);
    if (!(nearest2 > nearest_ * nearest_ * h * h)) return false;
    for (const std::uint32_t t : cavity_) {
      for (const std::uint32_t v : grid_.tets[t].v)
        if (vertex_seen_[v] != vertex_stamp_) return false;  // it would be lost
      for (int f = 0; f < 4; ++f)
        if (grid_.tets[t].facet[f] != kNothing && height_over(grid_.face(t, f), p) < kOverFacet * h)
          return false;
    }
    sizes_[spare_] = best;
    return true;
  }

  double height_over(const Face3& w, const Point& p) const {
    const Point& a = grid_.points[w[0]];
    const Vec normal = cross(grid_.points[w[1]] - a, grid_.points[w[2]] - a);
    return dot(normal, p - a) / norm(normal);
  }

  bool fill() {
    const auto slots = grid_.fill_star(cavity_, fresh_);
    slots_.assign(slots.begin(), slots.end());
    for (const std::uint32_t t : slots_) look_at(t);
    spare_ = add_point();
    return true;
  }

  TetGrid& grid_;
  std::span<const SizeSource> sources_;
  const std::vector<Point>& origins_;
  std::vector<SpreadSize> sizes_;
  const double largest_;
  const std::uint32_t frozen_;
  bool meets_frozen_ = false;  ///< has met a tet that stays, since advance_from() began
  std::uint32_t spare_ = kNothing;
  std::vector<Sphere> spheres_;
  std::vector<char> large_;
  double nearest_ = kNearest;
  std::size_t most_tets_ = kMostTets;
  std::priority_queue<Huge> huge_;
  std::vector<std::uint32_t> queue_, slots_, cavity_, excluded_, seen_, vertex_seen_;
  std::uint32_t stamp_ = 0, vertex_stamp_ = 0;
  std::vector<Tet4> fresh_;
};

/// Fronts in blocks, at the same time: what is left lies between the blocks.
Front::State advance_in_blocks(TetGrid& grid, std::size_t count, std::span<const SizeSource> sources,
                               std::vector<SpreadSize> sizes, double largest,
                               const std::atomic<bool>* interrupt) {
  std::vector<GridBlock> blocks = divide(grid, count);
  std::vector<Front::State> states(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t b) {
    std::vector<SpreadSize> own;
    for (const std::uint32_t v : blocks[b].vertices) own.push_back(sizes[v]);
    Front front(blocks[b].grid, sources, grid.points, std::move(own), largest, blocks[b].frozen);
    front.advance(interrupt);
    states[b] = front.take_state();
  });
  const std::vector<JoinedNumbers> numbers = join(grid, blocks);
  Front::State whole = {std::move(sizes), {}};
  whole.sizes.resize(grid.points.size());
  whole.large.resize(grid.tets.size());
  for (std::size_t b = 0; b < count; ++b) {
    for (std::size_t v = 0; v < numbers[b].points.size(); ++v)
      whole.sizes[numbers[b].points[v]] = states[b].sizes[v];
    for (std::size_t t = 0; t < numbers[b].tets.size(); ++t)
      whole.large[numbers[b].tets[t]] = states[b].large[t];
  }
  return whole;
}

}  // namespace

std::vector<SpreadSize> insert_inner_points(TetGrid& grid, std::span<const SizeSource> sources,
                                            std::vector<SpreadSize> sizes, double largest, int threads,
                                            const std::atomic<bool>* interrupt) {
  flip_to_delaunay(grid, interrupt);
  Front front(grid, sources, grid.points, std::move(sizes), largest);
  front.insert_far_apart(interrupt);
  constexpr std::size_t kLeastTets = 5000;  // of a block
  const std::size_t blocks =
      std::min(static_cast<std::size_t>(std::max(1, threads)), grid.tets.size() / kLeastTets);
  if (blocks < 2) {
    front.advance(interrupt);
    return front.take_state().sizes;
  }
  Front::State state = advance_in_blocks(grid, blocks, sources, front.take_state().sizes, largest, interrupt);
  Front seams(grid, sources, grid.points, std::move(state.sizes), largest);
  seams.set_large(std::move(state.large));
  seams.advance(interrupt);
  return seams.take_state().sizes;
}

}  // namespace weft::meshing
