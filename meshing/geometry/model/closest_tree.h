// A bounding volume hierarchy over several sets of small things: the closest thing of one set to a point.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/point.h"

namespace weft::meshing {

/// Several trees in one pair of arrays. Immutable once built; queries allocate nothing.
class ClosestForest {
 public:
  struct Item {
    Box box;
    std::uint32_t id;
  };

  /// Adds a tree over `items` (reordered; not empty) and returns its root. O(n log n). `leaf`: items of one;
  /// twice as many take half of the memory.
  std::uint32_t add(std::vector<Item>& items, std::ptrdiff_t leaf = 4);

  /// The id in the tree of `root` for which distance2(id) is least.
  template <class Distance2>
  std::uint32_t closest(std::uint32_t root, const Point& p, const Distance2& distance2) const;

  /// Calls visit(id) for everything in the tree of `root` whose box is at most sqrt(limit2) from p, and for
  /// some that is farther, first what is in the nearer boxes. visit() may lower limit2.
  template <class Visit>
  void visit_within(std::uint32_t root, const Point& p, const double& limit2, const Visit& visit) const;

  /// At most `most` (1 and more) boxes, which together have all items of the tree.
  std::vector<Box> boxes(std::uint32_t root, std::size_t most) const;

 private:
  struct Node {
    Box box;
    std::uint32_t first = 0;  ///< of a leaf: in ids_; else the first of two neighbouring children
    std::uint32_t count = 0;  ///< of a leaf; else zero
  };
  void split(std::uint32_t node, Item* begin, Item* end, std::ptrdiff_t leaf);
  /// Visits the items of all nodes but those for whose squared distance skip() is true; near ones first.
  template <class Skip, class Visit>
  void walk(std::uint32_t root, const Point& p, const Skip& skip, const Visit& visit) const;

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> ids_;
};

inline std::uint32_t ClosestForest::add(std::vector<Item>& items, std::ptrdiff_t leaf) {
  const auto root = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  split(root, items.data(), items.data() + items.size(), leaf);
  return root;
}

inline void ClosestForest::split(std::uint32_t node, Item* begin, Item* end, std::ptrdiff_t leaf) {
  Box box, centers;
  for (const Item* i = begin; i != end; ++i) {
    box.unite(i->box);
    centers.include(midpoint(i->box.lo, i->box.hi));
  }
  nodes_[node].box = box;
  if (end - begin <= leaf) {
    nodes_[node].first = static_cast<std::uint32_t>(ids_.size());
    nodes_[node].count = static_cast<std::uint32_t>(end - begin);
    for (const Item* i = begin; i != end; ++i) ids_.push_back(i->id);
    return;
  }
  const Vec size = centers.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  Item* middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [axis](const Item& a, const Item& b) {
    const double ca = a.box.lo[axis] + a.box.hi[axis], cb = b.box.lo[axis] + b.box.hi[axis];
    return ca != cb ? ca < cb : a.id < b.id;
  });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = children;
  split(children, begin, middle, leaf);
  split(children + 1, middle, end, leaf);
}

inline std::vector<Box> ClosestForest::boxes(std::uint32_t root, std::size_t most) const {
  std::vector<std::uint32_t> level{root};
  for (bool finer = true; finer && 2 * level.size() <= most;) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t node : level) {
      const bool leaf = nodes_[node].count > 0;
      next.push_back(leaf ? node : nodes_[node].first);
      if (!leaf) next.push_back(nodes_[node].first + 1);
    }
    finer = next.size() > level.size();
    level = std::move(next);
  }
  std::vector<Box> boxes;
  for (const std::uint32_t node : level) boxes.push_back(nodes_[node].box);
  return boxes;
}

template <class Skip, class Visit>
void ClosestForest::walk(std::uint32_t root, const Point& p, const Skip& skip, const Visit& visit) const {
  std::uint32_t stack[96];  // halving 2^32 items leaves depth below 32
  int top = 0;
  stack[top++] = root;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (skip(node.box.distance2(p))) continue;
    if (node.count == 0) {
      const bool left_first = nodes_[node.first].box.distance2(p) <= nodes_[node.first + 1].box.distance2(p);
      stack[top++] = node.first + (left_first ? 1 : 0);
      stack[top++] = node.first + (left_first ? 0 : 1);
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(ids_[i]);
  }
}

template <class Distance2>
std::uint32_t ClosestForest::closest(std::uint32_t root, const Point& p, const Distance2& distance2) const {
  std::uint32_t best = std::numeric_limits<std::uint32_t>::max();
  double best_distance2 = std::numeric_limits<double>::infinity();
  walk(
      root, p, [&](double box_distance2) { return box_distance2 >= best_distance2; },
      [&](std::uint32_t id) {
        const double d2 = distance2(id);
        if (d2 < best_distance2) {
          best_distance2 = d2;
          best = id;
        }
      });
  return best;
}

template <class Visit>
void ClosestForest::visit_within(std::uint32_t root, const Point& p, const double& limit2,
                                 const Visit& visit) const {
  walk(
      root, p, [&](double box_distance2) { return box_distance2 > limit2; }, visit);
}

}  // namespace weft::meshing
