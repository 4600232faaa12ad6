// Communication between ranks before and after the adaptation, as seen by plain algorithms: transport is not
// known here.
#pragma once

#include <cstddef>
#include <cstring>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

#include "meshing/base/release.h"

namespace weft::partition {

using Bytes = std::vector<std::byte>;

/// The ranks that work on one decomposition or one output together. All of them call the same functions in
/// the same order.
class Peers {
 public:
  static constexpr int kMostWriters = 64;

  virtual ~Peers() = default;
  virtual int rank() const = 0;
  virtual int ranks() const = 0;
  /// Sends to_each[r] to rank r (this one included) and returns what each rank has sent here.
  virtual std::vector<Bytes> all_to_all(std::vector<Bytes> to_each) = 0;
  /// What each rank gives, [r] of rank r, on all ranks.
  virtual std::vector<Bytes> allgather(Bytes mine) {
    return all_to_all(std::vector<Bytes>(static_cast<std::size_t>(ranks()), mine));
  }
  /// The same, one after the other in the order of the ranks.
  virtual Bytes allgather_joined(Bytes mine) {
    Bytes all;
    for (const Bytes& of_rank : allgather(std::move(mine)))
      all.insert(all.end(), of_rank.begin(), of_rank.end());
    return all;
  }

  /// At most so many ranks write to one file, or an eighth of all; the others hand them what they have of it.
  int most_writers() const { return most_writers_; }
  /// The same on all ranks, at least 1.
  void set_most_writers(int most) { most_writers_ = most; }

  /// Puts the second into the first: associative and commutative to the bit.
  using Combine = std::function<void(Bytes& sum, const Bytes& more)>;
  /// What all ranks give, combined, on all ranks.
  virtual Bytes reduce(Bytes mine, const Combine& combine) {
    std::vector<Bytes> all = allgather(std::move(mine));
    for (std::size_t r = 1; r < all.size(); ++r) combine(all[0], all[r]);
    return std::move(all[0]);
  }

 private:
  int most_writers_ = kMostWriters;
};

/// One rank.
class SelfPeers final : public Peers {
 public:
  int rank() const override { return 0; }
  int ranks() const override { return 1; }
  std::vector<Bytes> all_to_all(std::vector<Bytes> to_each) override { return to_each; }
};

inline void append(Bytes& bytes, const void* data, std::size_t size) {
  const auto* begin = static_cast<const std::byte*>(data);
  bytes.insert(bytes.end(), begin, begin + size);
}

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  Bytes bytes(values.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

template <class T>
std::vector<T> values_of(const Bytes& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

/// Each array is given back as soon as it is copied: all of them together may be most of a rank's memory.
template <class T>
std::vector<std::vector<T>> values_of_each(std::vector<Bytes> bytes) {
  std::vector<std::vector<T>> values;
  values.reserve(bytes.size());
  for (Bytes& of_rank : bytes) {
    values.push_back(values_of<T>(of_rank));
    meshing::release(of_rank);
  }
  return values;
}

/// Arrays of plain data: to_each[r] goes to rank r; result[r] came from rank r. Callers that need `to_each`
/// no more move it here: what stays on this rank is not copied then.
template <class T>
std::vector<std::vector<T>> all_to_all(Peers& peers, std::vector<std::vector<T>> to_each) {
  const auto me = static_cast<std::size_t>(peers.rank());
  std::vector<T> mine = std::exchange(to_each[me], {});
  std::vector<Bytes> bytes;
  bytes.reserve(to_each.size());
  for (std::vector<T>& values : to_each) {
    bytes.push_back(bytes_of(values));
    meshing::release(values);
  }
  to_each = {};
  std::vector<std::vector<T>> arrived = values_of_each<T>(peers.all_to_all(std::move(bytes)));
  arrived[me] = std::move(mine);
  return arrived;
}

/// The same, joined: in the order of the ranks, and nothing twice at a time.
template <class T>
std::vector<T> all_to_all_joined(Peers& peers, std::vector<std::vector<T>> to_each) {
  std::vector<std::vector<T>> arrived = partition::all_to_all(peers, std::move(to_each));
  if (arrived.size() == 1) return std::move(arrived[0]);
  std::size_t size = 0;
  for (const std::vector<T>& of_rank : arrived) size += of_rank.size();
  std::vector<T> all;
  all.reserve(size);
  for (std::vector<T>& of_rank : arrived) {
    all.insert(all.end(), of_rank.begin(), of_rank.end());
    meshing::release(of_rank);
  }
  return all;
}

/// The same array to every rank: result[r] is that of rank r.
template <class T>
std::vector<std::vector<T>> allgather(Peers& peers, const std::vector<T>& mine) {
  return values_of_each<T>(peers.allgather(bytes_of(mine)));
}

/// The same, joined in the order of the ranks.
template <class T>
std::vector<T> allgather_joined(Peers& peers, const std::vector<T>& mine) {
  return values_of<T>(peers.allgather_joined(bytes_of(mine)));
}

}  // namespace weft::partition
