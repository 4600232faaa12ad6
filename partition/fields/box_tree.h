// Boxes as a tree: whether something meets any of them.
#pragma once

#include <bit>
#include <cstddef>
#include <span>
#include <vector>

#include "meshing/base/box.h"

namespace weft::partition {

class BoxTree {
 public:
  /// Fast where boxes that follow each other are near each other.
  explicit BoxTree(std::span<const meshing::Box> boxes)
      : first_leaf_(std::bit_ceil(boxes.size() + 1)), nodes_(2 * first_leaf_), last_(first_leaf_) {
    for (std::size_t i = 0; i < boxes.size(); ++i) nodes_[first_leaf_ + i] = boxes[i];
    for (std::size_t i = first_leaf_ - 1; i > 0; --i) {
      nodes_[i].unite(nodes_[2 * i]);
      nodes_[i].unite(nodes_[2 * i + 1]);
    }
  }

  /// Begins beside what was met last and goes up from there: fast where those asked for follow each other.
  bool meets(const meshing::Box& box) {
    if (!nodes_[1].meets(box)) return false;
    if (nodes_[last_].meets(box)) return true;
    for (std::size_t node = last_; node > 1; node /= 2)
      if (meets(box, node ^ 1)) return true;
    return false;
  }

 private:
  bool meets(const meshing::Box& box, std::size_t node) {
    if (!nodes_[node].meets(box)) return false;
    if (node < first_leaf_) return meets(box, 2 * node) || meets(box, 2 * node + 1);
    last_ = node;
    return true;
  }

  std::size_t first_leaf_;
  std::vector<meshing::Box> nodes_;  ///< node i has the parts 2 i and 2 i + 1; empty boxes meet nothing
  std::size_t last_;                 ///< the leaf that was met last
};

}  // namespace weft::partition
