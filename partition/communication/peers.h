// Communication between ranks before and after the adaptation, as seen by plain algorithms: transport is not
// known here.
#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace weft::partition {

using Bytes = std::vector<std::byte>;

/// The ranks that work on one decomposition or one output together. All of them call the same functions in
/// the same order.
class Peers {
 public:
  virtual ~Peers() = default;
  virtual int rank() const = 0;
  virtual int ranks() const = 0;
  /// Sends to_each[r] to rank r (this one included) and returns what each rank has sent here.
  virtual std::vector<Bytes> all_to_all(std::vector<Bytes> to_each) = 0;
};

/// One rank.
class SelfPeers final : public Peers {
 public:
  int rank() const override { return 0; }
  int ranks() const override { return 1; }
  std::vector<Bytes> all_to_all(std::vector<Bytes> to_each) override { return to_each; }
};

/// Arrays of plain data: to_each[r] goes to rank r; result[r] came from rank r.
template <class T>
std::vector<std::vector<T>> all_to_all(Peers& peers, const std::vector<std::vector<T>>& to_each) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::vector<Bytes> bytes(to_each.size());
  for (std::size_t r = 0; r < to_each.size(); ++r) {
    bytes[r].resize(to_each[r].size() * sizeof(T));
    if (!bytes[r].empty()) std::memcpy(bytes[r].data(), to_each[r].data(), bytes[r].size());
  }
  bytes = peers.all_to_all(std::move(bytes));
  std::vector<std::vector<T>> received(bytes.size());
  for (std::size_t r = 0; r < bytes.size(); ++r) {
    received[r].resize(bytes[r].size() / sizeof(T));
    if (!bytes[r].empty()) std::memcpy(received[r].data(), bytes[r].data(), bytes[r].size());
  }
  return received;
}

/// The same array to every rank: result[r] is that of rank r.
template <class T>
std::vector<std::vector<T>> allgather(Peers& peers, const std::vector<T>& mine) {
  return all_to_all(peers, std::vector<std::vector<T>>(static_cast<std::size_t>(peers.ranks()), mine));
}

}  // namespace weft::partition
