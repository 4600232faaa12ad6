// What a rank has heard of the loads of others, and who of them has most.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/paged_table.h"
#include "engine/base/rank.h"

namespace weft::engine {

/// An idle rank wants to know who has most each time it asks for work: with thousands of ranks it must not
/// look at all of them for that, but at the most of each block of ranks.
class LoadTable {
 public:
  explicit LoadTable(std::size_t ranks) : loads_(ranks) {}

  /// -1: nothing has been heard.
  double of(Rank rank) const {
    const Entry* entry = loads_.find(rank.index());
    return entry == nullptr ? -1 : entry->load;
  }

  void set(Rank rank, double load) {
    double& mine = loads_[rank.index()].load;
    const double before = mine;
    mine = load;
    if (most_.empty()) most_.resize(loads_.size() / kBlock + 1, 0);
    double& most = most_[rank.index() / kBlock];
    if (load >= most) {
      most = load;
    } else if (before == most) {
      most = most_of(rank.index() / kBlock);
    }
  }

  /// The one with the greatest load above 0, the first of equal ones.
  Rank most_loaded() const {
    const auto block = std::max_element(most_.begin(), most_.end());
    if (block == most_.end() || *block <= 0) return Rank();
    std::size_t r = static_cast<std::size_t>(block - most_.begin()) * kBlock;
    while (of(Rank(static_cast<int>(r))) != *block) ++r;
    return Rank(static_cast<int>(r));
  }

 private:
  static constexpr std::size_t kBlock = 16;
  struct Entry {
    double load = -1;
  };

  double most_of(std::size_t block) const {
    double most = 0;
    for (std::size_t r = block * kBlock; r < std::min((block + 1) * kBlock, loads_.size()); ++r)
      most = std::max(most, of(Rank(static_cast<int>(r))));
    return most;
  }

  PagedTable<Entry> loads_;
  std::vector<double> most_;  ///< by block; 0: none has any. Empty until the first load
};

}  // namespace weft::engine
