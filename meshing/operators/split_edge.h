// Edge split: a vertex is created on an edge and every tet of the shell becomes two.
#pragma once

#include <span>

#include "meshing/kernel/kernel.h"

namespace weft::meshing {

/// Share of the way from a to b at which both halves of an edge are equally long, when it has length `la` in
/// the metric of a, `lb` in that of b, and sizes vary geometrically along it.
double metric_middle(double la, double lb);

/// What a split may not do.
struct SplitBounds {
  double shortest;  ///< no new edge shorter than this
  /// No new tet is worse than quality_share of limits.split_quality, unless better than keep_share of the
  /// worst before.
  double keep_share = 0.8;
  double quality_share = 1;
  bool must_improve = false;  ///< instead, all new tets are better than the worst before
  bool at_best = false;       ///< the new vertex of an inner edge goes where its tets are best
  bool on_chord = false;      ///< the new vertex stays on the edge where the boundary is curved, too
};

/// Splits edge (a, b) of the claimed tet `t` at its middle in the metric; on curved boundary the new vertex
/// is put on the reference surface. Refuses what would invert or break `bounds`. All touched vertices stay
/// claimed; the caller releases.
/// `made`: where not null, becomes the new vertex.
Verdict split_edge(Worker& w, TetId t, VertexId a, VertexId b, const SplitBounds& bounds,
                   VertexId* made = nullptr);

/// Where and what a vertex is that the caller puts on an edge.
struct VertexOnEdge {
  Point x;
  LogMetric log_metric;
  VertexKind kind = VertexKind::interior;
  CurveId curve;  ///< of a feature edge
  std::uint32_t background_hint = 0, surface_hint = 0;
};

/// Splits edge (a, b) at `at`, without quality checks: `fans` holds one tet of each set of tets that are
/// joined around the edge in this mesh (several when others have the tets between them). Everything must be
/// free to be claimed. Returns the new vertex, or an invalid one and no change when a tet would not be
/// positive.
VertexId split_edge_at(Worker& w, VertexId a, VertexId b, std::span<const TetId> fans,
                       const VertexOnEdge& at);

}  // namespace weft::meshing
