// Points that several pieces of a mesh have become one, on ranks of which none holds all.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/point.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"

namespace weft::partition {

/// The points of the pieces, put one after the other, lie in shares on the ranks, in their order. Copies are
/// the same point; its number is the one that meshing::merge_pieces() gives it. What all copies should have
/// alike and do not is taken of the same copy as there.
class JoinedPoints {
 public:
  /// All ranks. Copies are points with the same ID, or without IDs (by_ids is false on all ranks) at the same
  /// place, where -0 is 0; `ids` is empty then. Throws meshing::InputError, alike, where the numbers of
  /// points do not fit 32 bits.
  JoinedPoints(Peers& peers, std::span<const meshing::Point> copies, std::span<const std::int64_t> ids,
               bool by_ids);

  /// All ranks: the points of one piece, all of them different. Throws as above.
  JoinedPoints(Peers& peers, std::uint64_t num_points_here);

  /// How many points there are.
  std::uint64_t total() const { return total_; }

  /// All ranks: the numbers of the points that these copies are; `copies` ascend.
  std::vector<std::uint32_t> numbers_of(Peers& peers, const std::vector<std::uint64_t>& copies) const {
    return fetch<std::uint32_t>(peers, copies_, copies, [&](std::size_t i) { return numbers_[i]; });
  }

  /// Which copy of a point says what it is like.
  enum class Copy { first, last };
  /// All ranks: a value for each point of this rank's range of `points`, of the values of the copies here.
  template <class T>
  std::vector<T> deal(Peers& peers, const std::vector<T>& values, Copy copy, const Ranges& points) const {
    const std::vector<std::uint8_t>& speaks = copy == Copy::first ? is_first_ : is_last_;
    std::vector<std::vector<std::uint32_t>> numbers(static_cast<std::size_t>(peers.ranks()));
    std::vector<std::vector<T>> rows(numbers.size());
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      if (!speaks[i]) continue;
      const std::size_t rank = points.rank_of(numbers_[i]);
      numbers[rank].push_back(numbers_[i]);
      rows[rank].push_back(values[i]);
    }
    const auto numbers_here = all_to_all_joined(peers, std::move(numbers));
    const auto rows_here = all_to_all_joined(peers, std::move(rows));
    std::vector<T> dealt(points.first(peers.rank() + 1) - points.first(peers.rank()));
    for (std::size_t i = 0; i < rows_here.size(); ++i)
      dealt[numbers_here[i] - points.first(peers.rank())] = rows_here[i];
    return dealt;
  }

 private:
  std::vector<std::uint64_t> find_first_copies(Peers& peers, std::span<const meshing::Point> copies,
                                               std::span<const std::int64_t> ids, bool by_ids);
  void number_by_first_copies(Peers& peers, const std::vector<std::uint64_t>& first_copies);
  bool ids_are_numbers(Peers& peers, std::span<const std::int64_t> ids) const;

  Ranges copies_;
  std::uint64_t total_ = 0;
  std::vector<std::uint32_t> numbers_;            ///< of the copies here
  std::vector<std::uint8_t> is_first_, is_last_;  ///< flags: of all copies of the point
};

}  // namespace weft::partition
