// The background: an immutable mesh with its metric, where new and moved vertices read theirs.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "meshing/geometry/model/closest_tree.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// Some tets of a background that is not one mesh. Others may have the same arrays: what is of one background
/// alone is where tets beyond open faces are.
struct BackgroundBlock {
  static constexpr int kBits = 9;
  static constexpr std::size_t kMostTets = std::size_t{1} << kBits;
  /// In `neighbours`, with the number of an open face: what lies beyond it is another block's.
  static constexpr std::uint32_t kOpen = 0x80000000u;

  const Point* points = nullptr;
  const LogMetric* log_metrics = nullptr;
  const std::array<std::uint32_t, 4>* tets = nullptr;        ///< by the block's points
  const std::array<std::uint32_t, 4>* neighbours = nullptr;  ///< as Adjacency, by the block's tets
  /// Of each open face: the other side, as in Adjacency by the background's tets, or kNoNeighbour. Null where
  /// the block is the whole background: `neighbours` has no open faces then.
  const std::uint32_t* across = nullptr;
  std::uint32_t num_tets = 0;
  std::uint32_t first_code = 0;  ///< of the block's first face among the background's
};

/// Log-Euclidean P1 interpolation (Arsigny et al. 2006) of a metric field, found by walking from a nearby
/// tet. Never diffuses: every query reads the input's own metric. Safe to read from many threads.
class Background {
 public:
  static constexpr std::uint32_t kNoHint = 0xFFFFFFFFu;

  /// Refers to `mesh` and `log_metrics`, which must outlive it; `adjacency` is that of `mesh.tets`.
  Background(const MeshData& mesh, std::span<const LogMetric> log_metrics, Adjacency adjacency);

  /// Tet t of block b has the number b * BackgroundBlock::kMostTets + t. What blocks refer to must outlive
  /// it.
  explicit Background(std::vector<BackgroundBlock> blocks);

  struct Sample {
    LogMetric log_metric;
    std::uint32_t tet;  ///< the hint for the next query nearby
  };
  /// The metric at `p`; the walk starts at tet `hint` (kNoHint: anywhere). Outside the mesh: at its closest
  /// point.
  Sample at(const Point& p, std::uint32_t hint) const;

  struct WalkEnd {
    std::uint32_t tet;
    bool reached;  ///< the tet has the point; otherwise the boundary was in the way
  };
  /// Where the walk from tet `hint` towards `p` ends. Cheap: nothing is searched for beyond the boundary.
  WalkEnd walk_towards(const Point& p, std::uint32_t hint) const;

  /// Beyond a face, as in Adjacency.
  std::uint32_t neighbour(std::uint32_t tet, int face) const {
    const BackgroundBlock& block = block_of(tet);
    const std::uint32_t n = block.neighbours[tet & mask_][face];
    if (!block.across) return n;
    return n & BackgroundBlock::kOpen ? block.across[n ^ BackgroundBlock::kOpen] : block.first_code + n;
  }

  /// Of one that is a mesh.
  const LogMetric& log_metric(std::uint32_t vertex) const { return blocks_.front().log_metrics[vertex]; }

 private:
  using Barycentric = std::array<double, 4>;
  const BackgroundBlock& block_of(std::uint32_t tet) const { return blocks_[tet >> bits_]; }
  /// A tet's corners, and its block's points.
  struct Corners {
    const Point* points;
    const std::array<std::uint32_t, 4>& v;
    const Point& operator[](std::size_t i) const { return points[v[i]]; }
  };
  Corners corners(std::uint32_t tet) const {
    const BackgroundBlock& block = block_of(tet);
    return {block.points, block.tets[tet & mask_]};
  }
  Barycentric barycentric(std::uint32_t tet, const Point& p) const;
  Barycentric barycentric_in_flat(std::uint32_t tet, const Point& p) const;
  bool walk(const Point& p, std::uint32_t& tet, Barycentric& l) const;
  Point closest_in(std::uint32_t tet, const Point& p) const;
  Box box_of(std::uint32_t tet) const;
  std::uint32_t search_everywhere(const Point& p) const;
  Sample outside(const Point& p, std::uint32_t tet) const;
  LogMetric interpolate(std::uint32_t tet, const Barycentric& l) const;

  Adjacency adjacency_;  ///< of one that is a mesh
  int bits_ = 31;        ///< of a tet's number in its block
  std::uint32_t mask_ = 0x7FFFFFFFu;
  std::vector<BackgroundBlock> blocks_;
  // Built when walks end at the boundary too far from their points: the tree of all blocks by the first, that
  // of a block's tets by the first whose closest tet may be there. Few walks do, near few blocks.
  struct Tree {
    std::once_flag built;
    ClosestForest forest;
  };
  const ClosestForest& tree_of_blocks() const;
  const ClosestForest& tree_of(std::uint32_t block) const;
  mutable Tree blocks_tree_;
  mutable std::unique_ptr<Tree[]> trees_;  ///< by block, made with the tree of all
};

}  // namespace weft::meshing
