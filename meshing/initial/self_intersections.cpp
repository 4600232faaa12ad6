// A tree of boxes proposes pairs, exact predicates decide.
#include "meshing/initial/self_intersections.h"

#include <tbb/concurrent_vector.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "meshing/base/box.h"
#include "meshing/initial/grid/interrupted.h"
#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

/// A balanced tree in the order of an array: the node of [begin, end) splits at the middle.
class BoxTree {
 public:
  explicit BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.resize(4 * boxes_.size() + 4);
    build(1, 0, order_.size());
  }

  template <class Visit>
  void visit_overlapping(const Box& box, const Visit& visit) const {
    descend(1, 0, order_.size(), box, visit);
  }

 private:
  static constexpr std::size_t kLeaf = 4;

  void build(std::size_t node, std::size_t begin, std::size_t end) {
    Box all, centres;
    for (std::size_t i = begin; i < end; ++i) {
      const Box& b = boxes_[order_[i]];
      all.unite(b);
      centres.include(midpoint(b.lo, b.hi));
    }
    nodes_[node] = all;
    if (end - begin <= kLeaf) return;
    const Vec size = centres.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      const double x = boxes_[a].lo[axis] + boxes_[a].hi[axis], y = boxes_[b].lo[axis] + boxes_[b].hi[axis];
      return x != y ? x < y : a < b;
    });
    build(2 * node, begin, middle);
    build(2 * node + 1, middle, end);
  }

  template <class Visit>
  void descend(std::size_t node, std::size_t begin, std::size_t end, const Box& box,
               const Visit& visit) const {
    if (!nodes_[node].meets(box)) return;
    if (end - begin <= kLeaf) {
      for (std::size_t i = begin; i < end; ++i)
        if (boxes_[order_[i]].meets(box)) visit(order_[i]);
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    descend(2 * node, begin, middle, box, visit);
    descend(2 * node + 1, middle, end, box, visit);
  }

  std::vector<Box> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Box> nodes_;
};

class PairJudge {
 public:
  PairJudge(std::span<const Point> points, std::span<const Triangle> triangles)
      : points_(points), triangles_(triangles) {}

  std::array<Point, 3> corners(std::uint32_t t) const {
    const Triangle& v = triangles_[t];
    return {points_[v[0]], points_[v[1]], points_[v[2]]};
  }

  /// Whether two triangles meet outside the vertices that they share.
  bool meet(std::uint32_t s, std::uint32_t t) const {
    Triangle a = triangles_[s], b = triangles_[t];
    const int shared = bring_shared_first(a, b);
    if (shared == 0) return triangles_meet(corners(s), corners(t));
    if (shared == 1)
      return segment_meets_triangle(points_[a[1]], points_[a[2]], corners(t)) ||
             segment_meets_triangle(points_[b[1]], points_[b[2]], corners(s));
    if (shared == 3) return true;
    const Point &p = points_[a[0]], &q = points_[a[1]], &x = points_[a[2]], &y = points_[b[2]];
    return orientation(p, q, x, y) == 0 && on_same_side(p, q, x, y);
  }

 private:
  /// Reorders both so that the vertices they share stand first, in the same order; returns their number.
  static int bring_shared_first(Triangle& a, Triangle& b) {
    std::size_t shared = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = shared; j < 3; ++j)
        if (a[i] == b[j]) {
          std::swap(a[i], a[shared]);
          std::swap(b[j], b[shared]);
          ++shared;
          break;
        }
    return static_cast<int>(shared);
  }

  std::span<const Point> points_;
  std::span<const Triangle> triangles_;
};

}  // namespace

std::vector<std::array<std::uint32_t, 2>> self_intersections(std::span<const Point> points,
                                                             std::span<const Triangle> triangles,
                                                             std::size_t most,
                                                             const std::atomic<bool>* interrupt) {
  const PairJudge judge(points, triangles);
  std::vector<Box> boxes(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (const Point& p : judge.corners(t)) boxes[t].include(p);
  const BoxTree tree(boxes);
  // In chunks of first triangles, each twice as long as the one before: later ones have no lower pairs, for
  // any number of threads.
  std::size_t end = 0;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::size_t begin = 0; begin < triangles.size() && pairs.size() < most; begin = end) {
    end = std::min(triangles.size(), 2 * begin + 512);
    tbb::concurrent_vector<std::array<std::uint32_t, 2>> found;
    tbb::parallel_for(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end),
                      [&](std::uint32_t s) {
                        check_interrupt(interrupt);
                        tree.visit_overlapping(boxes[s], [&](std::uint32_t t) {
                          if (s < t && judge.meet(s, t)) found.push_back({s, t});
                        });
                      });
    pairs.insert(pairs.end(), found.begin(), found.end());
    std::sort(pairs.end() - static_cast<std::ptrdiff_t>(found.size()), pairs.end());
  }
  if (pairs.size() > most) pairs.resize(most);
  return pairs;
}

}  // namespace weft::meshing
