// Counts what a rank receives.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::support {

/// Notes the greatest number of bytes that a rank gets at once, and how often it has exchanged something.
class CountingPeers final : public partition::Peers {
 public:
  explicit CountingPeers(partition::Peers& peers) : peers_(peers) {}
  int rank() const override { return peers_.rank(); }
  int ranks() const override { return peers_.ranks(); }
  std::vector<partition::Bytes> all_to_all(std::vector<partition::Bytes> to_each) override {
    std::size_t bytes = 0;
    auto received = peers_.all_to_all(std::move(to_each));
    for (const partition::Bytes& part : received) bytes += part.size();
    most = std::max(most, bytes);
    ++exchanges;
    return received;
  }
  /// Over a tree: of two children, and from above.
  partition::Bytes reduce(partition::Bytes mine, const Combine& combine) override {
    most = std::max(most, 3 * mine.size());
    ++exchanges;
    return peers_.reduce(std::move(mine), combine);
  }
  std::size_t most = 0, exchanges = 0;

 private:
  partition::Peers& peers_;
};

}  // namespace weft::support
