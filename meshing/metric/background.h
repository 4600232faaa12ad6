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

/// Log-Euclidean P1 interpolation (Arsigny et al. 2006) of a metric field, found by walking from a nearby
/// tet. Never diffuses: every query reads the input's own metric. Safe to read from many threads.
class Background {
 public:
  static constexpr std::uint32_t kNoHint = 0xFFFFFFFFu;

  /// Refers to `mesh` and `log_metrics`, which must outlive it; `adjacency` is that of `mesh.tets`.
  Background(const MeshData& mesh, std::span<const LogMetric> log_metrics, Adjacency adjacency);

  struct Sample {
    LogMetric log_metric;
    std::uint32_t tet;  ///< the hint for the next query nearby
  };
  /// The metric at `p`; the walk starts at tet `hint` (kNoHint: anywhere). Outside the mesh: at its closest
  /// point.
  Sample at(const Point& p, std::uint32_t hint) const;

  using Barycentric = std::array<double, 4>;
  struct Place {
    std::uint32_t tet;     ///< the hint for the next query nearby
    Barycentric at;        ///< weights of its vertices, none negative, of sum 1
    double distance2 = 0;  ///< squared, of the point from the mesh; 0 within 1e-6 of the tet's size
  };
  /// Where `p` is, or the point of the mesh closest to it; needs no metrics.
  Place locate(const Point& p, std::uint32_t hint) const;
  /// The same whatever the hint, and whatever is missing of the mesh farther off: of tets that have `p`, or
  /// its closest point, in common the first.
  Place locate_first(const Point& p, std::uint32_t hint) const;

  struct WalkEnd {
    std::uint32_t tet;
    bool reached;  ///< the tet has the point; otherwise the boundary was in the way
  };
  /// Where the walk from tet `hint` towards `p` ends. Cheap: nothing is searched for beyond the boundary.
  WalkEnd walk_towards(const Point& p, std::uint32_t hint) const;

  const LogMetric& log_metric(std::uint32_t vertex) const { return log_metrics_[vertex]; }
  const MeshData& mesh() const { return mesh_; }
  const Adjacency& adjacency() const { return adjacency_; }
  /// Gives the adjacency back; nothing may be asked afterwards.
  Adjacency release_adjacency() { return std::move(adjacency_); }

 private:
  Barycentric barycentric(std::uint32_t tet, const Point& p) const;
  Barycentric barycentric_in_flat(std::uint32_t tet, const Point& p) const;
  bool walk(const Point& p, std::uint32_t& tet, Barycentric& l) const;
  Point closest_in(std::uint32_t tet, const Point& p) const;
  std::vector<std::uint32_t> tets_about(std::uint32_t tet, const Point& q) const;
  std::uint32_t search_everywhere(const Point& p) const;
  Sample outside(const Point& p, std::uint32_t tet) const;
  LogMetric interpolate(std::uint32_t tet, const Barycentric& l) const;

  const MeshData& mesh_;
  std::span<const LogMetric> log_metrics_;
  Adjacency adjacency_;
  // Built when a walk first ends at the boundary too far from its point: many backgrounds never need it.
  mutable std::once_flag tree_built_;
  mutable std::unique_ptr<ClosestForest> tree_;
};

}  // namespace weft::meshing
