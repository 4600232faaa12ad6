// Whether a mesh fits its metric already, so that an adaptation would change next to nothing of it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"
#include "weft/data.h"

namespace weft::meshing {

/// Sums over tets in integers, which add up to the same whatever was summed first. Edges are counted as tets
/// have them, six each, and measured in the mean metric of the tet.
struct FitSums {
  std::uint64_t tets = 0, longer = 0, shorter = 0;
  std::uint64_t far = 0;      ///< tets of which few or none may be in a block
  std::uint64_t quality = 0;  ///< mean ratios, in 2^-32
  std::uint64_t volume = 0;   ///< in the metric, in 2^-32

  FitSums& operator+=(const FitSums& other);
  friend bool operator==(const FitSums&, const FitSums&) = default;
  /// Of a block: whether it is as those of adapted meshes are.
  bool fits() const;
  MetricFit shares() const;
};

/// Tets are judged in blocks as they follow each other, so that what is wrong in a part of the mesh shows: of
/// this many, of the last one up to twice as many. Shares of smaller blocks scatter too much to be judged.
inline constexpr std::uint64_t kTetsOfBlock = 8192;
/// None where the mesh has too few tets.
constexpr std::uint64_t blocks_of(std::uint64_t num_tets) { return num_tets / kTetsOfBlock; }
/// The first tet of a block, the number of all for the one behind the last.
constexpr std::uint64_t first_of_block(std::uint64_t block, std::uint64_t num_tets) {
  return block < blocks_of(num_tets) ? block * kTetsOfBlock : num_tets;
}

/// False where a mesh of so many tets in a metric of this complexity cannot fit, whatever its tets are like.
bool may_fit(std::uint64_t num_tets, double complexity);

/// The blocks that consecutive tets are in, of which the first and the last may have others too.
struct FitBlocks {
  std::uint64_t first = 0;  ///< its number
  std::vector<FitSums> sums;
};

/// Sums the blocks of `tets`, which have the numbers from `first_tet` on in a mesh of `num_tets`. Empty as
/// soon as a block that is whole does not fit. Multithreaded on TBB; depends neither on the number of threads
/// nor on how a mesh was cut. The corners of all tets must be among the points.
std::optional<FitBlocks> sum_blocks(std::span<const std::array<std::uint32_t, 4>> tets,
                                    std::uint64_t first_tet, std::uint64_t num_tets,
                                    std::span<const Point> points, std::span<const LogMetric> log_metrics);

/// How many tets have a predecessor, and how many of these a vertex of it.
struct Followers {
  std::uint64_t all = 0, joined = 0;
  /// Four of five are joined, as in every mesh that weft has written; not in one whose tets come in any
  /// order.
  bool in_order() const { return 5 * joined >= 4 * all; }
  Followers& operator+=(const Followers& other) {
    all += other.all, joined += other.joined;
    return *this;
  }
};
Followers count_followers(std::span<const std::array<std::uint32_t, 4>> tets);

/// Of a whole mesh: empty where it does not fit. All of its blocks must be as those of adapted meshes are:
/// blocks whose edges are 5 % too long or too short in the metric are not. A mesh whose tets do not follow
/// each other, or with less than a block of them, is not judged, and does not fit.
std::optional<MetricFit> fit_of(const MeshData& mesh, std::span<const LogMetric> log_metrics);

}  // namespace weft::meshing
