// What an operator works with: the mesh, where it reads metric and geometry, its limits, one thread's
// scratch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "meshing/geometry/surface/surface.h"
#include "meshing/kernel/ball_objective.h"
#include "meshing/kernel/neighbourhood.h"
#include "meshing/kernel/quality.h"
#include "meshing/kernel/speculation.h"
#include "meshing/kernel/tet_mesh.h"
#include "meshing/kernel/verdict.h"
#include "meshing/metric/background.h"
#include "weft/data.h"

namespace weft::meshing {

/// Bounds that the judges apply. Lengths in the metric.
struct Limits {
  double long_edge = 1.41421356237309505;  ///< split beyond
  double finest_long_edge =
      1.41421356237309505;             ///< long_edge of the last level: shorter boundary edges are left alone
  double finest_split_shortest = 0.5;  ///< split_shortest of the last level
  double largest_bulge = 0.25;         ///< boundary edges that curve more than this are split first of all
  double short_edge = 0.70710678118654752;        ///< collapse below
  double collapse_longest = 1.41421356237309505;  ///< a collapse creates no edge longer than this
  double split_shortest = 0.5;                    ///< a split creates no edge shorter than this
  double shortest_at_curved = 0.5;  ///< so much in the place of finest_split_shortest, where smaller, of long
                                    ///< boundary edges that curve too much
  double split_quality =
      0.05;  ///< a split may lower quality down to this, or to this share of the worst before
  double collapse_quality = 0.3;  ///< a collapse may lower the worst quality to this
  double shortest_step = 0.03;    ///< shorter moves are not made
  double far_step = 0.1;          ///< longer moves make the neighbours worth smoothing again
  double hausd = 0;               ///< largest deviation of the boundary from the reference surface
  double details = kUnbounded;    ///< that of a patch on a CAD model is at most this many times Patch::detail

  /// The same for the metric divided by factor^2: all lengths are that much longer.
  Limits coarser(double factor) const;
};

inline Limits Limits::coarser(double factor) const {
  Limits limits = *this;
  for (double* length :
       {&limits.long_edge, &limits.finest_long_edge, &limits.finest_split_shortest, &limits.short_edge,
        &limits.collapse_longest, &limits.split_shortest, &limits.shortest_at_curved})
    *length *= factor;
  return limits;
}

/// How operators judge and what they may claim. Changed between passes only; when the mean changes, the
/// mesh's cached qualities are stale.
struct Policy {
  MetricMean mean = MetricMean::arithmetic;
  FrozenPolicy frozen = FrozenPolicy::claimable;
  AllowedOperations allowed = {};
};

struct Kernel {
  TetMesh& mesh;
  const Background& background;
  const Surface& surface;
  Limits limits;
  Policy policy = {};

  /// Largest deviation of a patch from the reference surface.
  double hausd(PatchId patch) const {
    return std::min(limits.hausd, limits.details * surface.patches()[patch.value].detail);
  }
};

/// A neighbour of a vertex and its distance in the metric.
struct Neighbour {
  VertexId vertex;
  double length;
};

/// One thread's scratch: claims, gathered neighbourhoods, free slots, counts. No allocation once warm.
struct Worker {
  Worker(Kernel& k, std::uint32_t owner, bool sole)
      : kernel(k), mesh(k.mesh), claims(k.mesh, owner, sole, k.policy.frozen) {}

  MetricMean mean() const { return kernel.policy.mean; }
  /// Of a vertex, for the judges.
  Corner corner(VertexId v) const { return meshing::corner(mean(), mesh, v); }

  Kernel& kernel;
  TetMesh& mesh;
  Claims claims;
  Ball ball, other_ball;
  Shell shell;
  SmallSet vertices_seen;
  std::vector<float> qualities;
  BallFaces faces;
  std::vector<Neighbour> short_edges;
  std::vector<Neighbour> neighbours;
  OperationCounts counts;
  std::vector<TetId> free_tets;
  std::vector<VertexId> free_vertices;

  /// Makes sure that so many slots are there to be taken, before an operator writes anything. False: the mesh
  /// is full, and the operator must refuse.
  bool secure(std::size_t tets, std::size_t vertices) {
    while (free_tets.size() < tets)
      if (!take_tets()) return false;
    while (free_vertices.size() < vertices)
      if (!take_vertices()) return false;
    return true;
  }
  /// Makes room in the lists for what an operator is about to free: a change that has begun must not fail for
  /// want of memory.
  void prepare_to_free(std::size_t tets, std::size_t vertices) {
    make_room_for(free_tets, tets);
    make_room_for(free_vertices, vertices);
  }
  /// A slot of those secured.
  TetId new_tet() {
    const TetId t = free_tets.back();
    free_tets.pop_back();
    return t;
  }
  /// A slot of those secured, claimed: a mark left over from the vertex that had the slot before may lead
  /// another thread to it. Invalid while such a thread holds it.
  VertexId new_vertex() {
    const VertexId v = free_vertices.back();
    if (claims.claim_new(v) != Verdict::accepted) return {};
    free_vertices.pop_back();
    return v;
  }
  void free(TetId t) {
    mesh.kill(t);
    free_tets.push_back(t);
  }
  void free(VertexId v) {
    mesh.kill(v);
    free_vertices.push_back(v);
  }

 private:
  static constexpr std::uint32_t kChunk = 64;
  template <class T>
  static void make_room_for(std::vector<T>& list, std::size_t more) {
    if (list.capacity() - list.size() < more) list.reserve(2 * list.capacity() + more);
  }
  bool take_tets() {
    const std::optional<std::uint32_t> first = mesh.try_take_tet_slots(kChunk);
    for (std::uint32_t i = kChunk; first && i-- > 0;) free_tets.push_back(TetId(*first + i));
    return first.has_value();
  }
  bool take_vertices() {
    const std::optional<std::uint32_t> first = mesh.try_take_vertex_slots(kChunk);
    for (std::uint32_t i = kChunk; first && i-- > 0;) free_vertices.push_back(VertexId(*first + i));
    return first.has_value();
  }
};

/// How an edge lies in the boundary: told by the patches of the faces around it.
struct EdgeClass {
  VertexKind kind = VertexKind::interior;  ///< interior, surface or ridge (a feature edge)
  PatchId patch;                           ///< of a surface edge
  CurveId curve;                           ///< of a feature edge
};
/// May the edge have tets outside this mesh?
inline bool incomplete(const TetMesh& mesh, const Shell& shell) {
  return !shell.closed && mesh.frozen(shell.a) && mesh.frozen(shell.b);
}
/// Classifies the edge of a gathered shell.
EdgeClass classify(const TetMesh& mesh, const Shell& shell);

}  // namespace weft::meshing
