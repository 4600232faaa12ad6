// Triangles of which every rank has a share: the closest of all to a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/geometry/model/closest_tree.h"
#include "meshing/geometry/surface/closest_triangles.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// A rank knows its share and a few boxes of each other one; points go to those whose boxes may have
/// something closer than is known. Few triangles are on all ranks: who has them would get the points of all.
class TrianglesInShares {
 public:
  using Triangle = meshing::ClosestTriangles::Triangle;
  using Found = meshing::ClosestTriangles::Found;

  struct Limits {
    std::uint64_t few = 256;  ///< so many triangles are on all ranks
    /// So many get to one rank at a time even if all ask it; 72 bytes each with the answer.
    std::uint64_t questions = 1 << 20;
  };

  /// All ranks; their corners are finite. Whatever each has, and one on several ranks too; there is less to
  /// send where those of a rank lie together. Limits are the same on all ranks.
  TrianglesInShares(Peers& peers, std::vector<Triangle> mine, const Limits& limits);
  TrianglesInShares(Peers& peers, std::vector<Triangle> mine)
      : TrianglesInShares(peers, std::move(mine), Limits()) {}

  /// All ranks: what meshing::ClosestTriangles of all shares finds for each point, the same bits for any
  /// shares. A point is sent to one rank, and then to those that may know something closer: seldom more than
  /// another one. Multithreaded.
  std::vector<Found> closest(std::span<const meshing::Point> points) const;

 private:
  struct Question {
    meshing::Point point;
    double limit2;
  };
  struct ShareBox {
    meshing::Box box;
    std::size_t rank;
  };

  std::size_t nearest_rank(const meshing::Point& p) const;
  void closest_of(std::span<const meshing::Point> points, std::span<Found> found) const;
  template <class RanksFor>
  void ask(std::span<const meshing::Point> points, const RanksFor& ranks_for, std::span<Found> found) const;

  Peers& peers_;
  Limits limits_;
  bool all_here_;
  meshing::ClosestTriangles mine_;
  std::vector<ShareBox> boxes_;  ///< of all shares, the same on all ranks
  meshing::ClosestForest tree_;  ///< of places in boxes_
  std::uint32_t root_ = 0;
};

}  // namespace weft::partition
