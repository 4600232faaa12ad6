// From a caller's ids to numbers without gaps, and back: ranges of ids have homes, so that no rank sees all
// of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::tools {

/// 0 where there are none.
inline std::uint64_t largest_id(const std::vector<std::uint64_t>& ids) {
  return ids.empty() ? 0 : std::ranges::max(ids);
}

/// The rank at which all records of an id meet: ids ascend with the ranks.
class IdHomes {
 public:
  /// All ranks: `largest` is the largest id here.
  IdHomes(partition::Peers& peers, std::uint64_t largest)
      : ranks_(static_cast<std::uint64_t>(peers.ranks())) {
    for (const auto& of_rank : partition::allgather(peers, std::vector<std::uint64_t>{largest}))
      last_ = std::max(last_, of_rank[0]);
  }
  std::size_t home(std::uint64_t id) const {
    if (ranks_ == 1) return 0;  // whatever the largest
    const std::uint64_t step = last_ / ranks_ + 1;
    return static_cast<std::size_t>(id / step);
  }

 private:
  std::uint64_t ranks_, last_ = 0;
};

/// Records sent to the homes of their ids, with the way back for answers in the order of the records.
template <class Record>
class IdMail {
 public:
  IdMail(partition::Peers& peers, const IdHomes& homes)
      : peers_(peers), homes_(homes), to_each_(static_cast<std::size_t>(peers.ranks())) {}

  void add(std::uint64_t id, const Record& record) {
    const std::size_t home = homes_.home(id);
    order_.push_back(home);
    to_each_[home].push_back(record);
  }
  /// All ranks: what has arrived here, by rank of origin.
  std::vector<std::vector<Record>> deliver() {
    auto arrived = partition::all_to_all(peers_, to_each_);
    to_each_.clear();
    return arrived;
  }
  /// All ranks, after deliver(): answers[r][i] is for arrived[r][i]; returns those to this rank's records.
  template <class Answer>
  std::vector<Answer> answer(const std::vector<std::vector<Answer>>& answers) {
    const auto back = partition::all_to_all(peers_, answers);
    std::vector<std::size_t> next(back.size());
    std::vector<Answer> mine;
    mine.reserve(order_.size());
    for (const std::size_t home : order_) mine.push_back(back[home][next[home]++]);
    return mine;
  }

 private:
  partition::Peers& peers_;
  const IdHomes& homes_;
  std::vector<std::size_t> order_;
  std::vector<std::vector<Record>> to_each_;
};

}  // namespace weft::tools
