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
      : first_leaf_(std::bit_ceil(boxes.size() + 1)), nodes_(2 * first_leaf_) {
    for (std::size_t i = 0; i < boxes.size(); ++i) nodes_[first_leaf_ + i] = boxes[i];
    for (std::size_t i = first_leaf_ - 1; i > 0; --i) {
      nodes_[i].unite(nodes_[2 * i]);
      nodes_[i].unite(nodes_[2 * i + 1]);
    }
  }

  bool meets(const meshing::Box& box) const { return meets(box, 1); }

 private:
  bool meets(const meshing::Box& box, std::size_t node) const {
    if (!nodes_[node].meets(box)) return false;
    return node >= first_leaf_ || meets(box, 2 * node) || meets(box, 2 * node + 1);
  }

  std::size_t first_leaf_;
  std::vector<meshing::Box> nodes_;  ///< node i has the parts 2 i and 2 i + 1; empty boxes meet nothing
};

}  // namespace weft::partition
