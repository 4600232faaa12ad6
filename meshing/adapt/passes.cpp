// What each pass does with one tet or vertex.
#include "meshing/adapt/passes.h"

#include <algorithm>
#include <array>

#include "meshing/operators/collapse_edge.h"
#include "meshing/operators/relocate_vertex.h"
#include "meshing/operators/smooth_vertex.h"
#include "meshing/operators/snap_vertex.h"
#include "meshing/operators/split_edge.h"
#include "meshing/operators/surface_fit.h"
#include "meshing/operators/swap_edge.h"
#include "meshing/operators/swap_face.h"

namespace weft::meshing {
namespace {

Verdict counted(Worker& w, Operator op, Verdict v) {
  w.counts.add(op, v);
  return v;
}

/// Counts a verdict and lets go of everything the operator claimed.
Verdict done(Worker& w, Operator op, Verdict v) {
  w.claims.release();
  return counted(w, op, v);
}

struct EdgeLength {
  int edge;
  double length;
};

/// Those edges of a claimed tet that are longer than a bound, by length, ascending.
struct LongEdges {
  std::array<EdgeLength, 6> edges;
  int size = 0;
};
LongEdges edges_above(double bound, const TetMesh& mesh, const TetVertices& v) {
  LongEdges found;
  for (int i = 0; i < 6; ++i) {
    const MetricLength length = edge_between(mesh, v[kTetEdges[i][0]], v[kTetEdges[i][1]]);
    if (length.above(bound)) found.edges[found.size++] = {i, length.value()};
  }
  std::stable_sort(found.edges.begin(), found.edges.begin() + found.size,
                   [](const EdgeLength& a, const EdgeLength& b) { return a.length < b.length; });
  return found;
}

bool has_edge_above(double bound, const TetMesh& mesh, const TetVertices& v) {
  return std::any_of(kTetEdges.begin(), kTetEdges.end(),
                     [&](const auto& e) { return edge_between(mesh, v[e[0]], v[e[1]]).above(bound); });
}

/// A tet that the input has lying upon a curved surface is raised by a vertex on one of its inner edges.
Verdict split_lying(Worker& w, TetId t, const TetVertices& v) {
  for (const auto& e : kTetEdges) {
    if (length_between(w.mesh, v[e[0]], v[e[1]]) <= w.kernel.limits.finest_long_edge) continue;
    if (const Verdict r = gather_shell(w.mesh, w.claims, t, v[e[0]], v[e[1]], w.shell);
        r != Verdict::accepted)
      return r;
    if (classify(w.mesh, w.shell).kind != VertexKind::interior) continue;
    const Verdict r = split_edge(w, t, v[e[0]], v[e[1]], {w.kernel.limits.finest_split_shortest});
    if (r == Verdict::accepted || r == Verdict::conflict) return r;
    w.counts.add(Operator::split, r);
  }
  return Verdict::not_needed;
}

/// Those neighbours of the gathered ball's centre that are nearer than `nearest`, by length, ascending.
void neighbours_within(Worker& w, double nearest, std::vector<Neighbour>& found) {
  found.clear();
  for (const auto& [u, first] : w.ball.link)
    if (const MetricLength length = edge_between(w.mesh, w.ball.centre, u); length.below(nearest))
      found.push_back({u, length.value()});
  std::sort(found.begin(), found.end(), [](const Neighbour& a, const Neighbour& b) {
    return a.length != b.length ? a.length < b.length : a.vertex < b.vertex;
  });
}

/// kHasShort says whether the last look found a short edge.
void remember_short(TetMesh& mesh, VertexId v, bool has_short) {
  if (has_short)
    mesh.mark(v, kHasShort);
  else
    mesh.take_marks(v, kHasShort);
}

/// Collapses the centre of the gathered ball into one of its neighbours nearer than `nearest`, the nearest
/// that can be. Counts what it tries, and leaves the claims.
Verdict collapse_gathered(Worker& w, double nearest, CollapseGoal goal) {
  const VertexId v = w.ball.centre;
  Verdict r = Verdict::not_needed;
  if (w.mesh.fixed(v)) return counted(w, Operator::collapse, r);
  std::vector<Neighbour>& found = w.neighbours;
  neighbours_within(w, nearest, found);
  if (goal == CollapseGoal::length) remember_short(w.mesh, v, !found.empty());
  if (found.empty()) return counted(w, Operator::collapse, r);
  for (const Neighbour& n : found) {
    r = counted(w, Operator::collapse, collapse_edge(w, v, n.vertex, goal));
    if (r == Verdict::accepted || r == Verdict::conflict) break;
  }
  return r;
}

/// Gathers and claims the ball of `v`. Anything but accepted is counted for `op`, and nothing claimed then.
Verdict gather(Worker& w, Operator op, VertexId v) {
  if (w.mesh.frozen(v)) return done(w, op, Verdict::frozen);
  const Verdict r = gather_ball(w.mesh, w.claims, v, w.ball);
  return r == Verdict::accepted ? r : done(w, op, r);
}

Verdict collapse_vertex(Worker& w, VertexId v, double nearest, CollapseGoal goal) {
  if (const Verdict r = gather(w, Operator::collapse, v); r != Verdict::accepted) return r;
  const Verdict r = collapse_gathered(w, nearest, goal);
  w.claims.release();
  return r;
}

/// What the marks say, with one look at the ball: its move may have made an edge short.
Verdict smooth_and_collapse(Worker& w, VertexId v, std::uint8_t marks) {
  const bool smooths = marks & kCheckPlace;
  if (const Verdict r = gather(w, smooths ? Operator::smooth : Operator::collapse, v); r != Verdict::accepted)
    return r;
  const Verdict smoothed = smooths ? counted(w, Operator::smooth, smooth_gathered(w)) : Verdict::not_needed;
  Verdict collapsed = Verdict::not_needed;
  if ((marks | w.mesh.take_marks(v, kCheckShort)) & kCheckShort)
    collapsed = collapse_gathered(w, w.kernel.limits.short_edge, CollapseGoal::length);
  w.claims.release();
  return collapsed == Verdict::accepted || collapsed == Verdict::conflict ? collapsed : smoothed;
}

/// The neighbours of a vertex that are inside; none where others hold them. Claims nothing in the end.
std::vector<VertexId> neighbours_inside(Worker& w, VertexId v) {
  std::vector<VertexId> inside;
  if (gather_ball(w.mesh, w.claims, v, w.ball) != Verdict::accepted) {
    w.claims.release();
    return inside;
  }
  for (const auto& [t, local] : w.ball.tets)
    for (const VertexId u : w.mesh.vertices(t))
      if (u != v && w.mesh.kind(u) == VertexKind::interior) inside.push_back(u);
  w.claims.release();
  std::sort(inside.begin(), inside.end());
  inside.erase(std::unique(inside.begin(), inside.end()), inside.end());
  return inside;
}

/// The neighbours of a vertex that is in its tets' way make room, those inside first.
void make_room(Worker& w, VertexId v) {
  for (const VertexId u : neighbours_inside(w, v)) {
    if (done(w, Operator::smooth, smooth_vertex(w, u)) == Verdict::accepted) continue;
    done(w, Operator::relocate, relocate_vertex(w, u));
  }
}

/// Takes back the split that has made `v` between `a` and `b`.
Verdict take_back(Worker& w, VertexId v, VertexId a, VertexId b) {
  Verdict r = Verdict::not_needed;
  for (const VertexId kept : {a, b}) {
    r = gather_ball(w.mesh, w.claims, v, w.ball);
    const auto has = [&](const Ball::Entry& e) { return w.mesh.local_index(e.tet, kept) >= 0; };
    if (r == Verdict::accepted)
      r = std::ranges::any_of(w.ball.tets, has) ? collapse_edge(w, v, kept, CollapseGoal::undo)
                                                : Verdict::breaks_topology;
    w.claims.release();
    if (r == Verdict::accepted) break;
  }
  return r;
}

/// Splits an edge of curved boundary where the surface lies behind what lies upon the edge: on the chord,
/// from where the new vertex rises while its neighbours make room. Where it does not arrive all is taken
/// back. Counts no split, and claims nothing in the end.
Verdict split_below(Worker& w, TetId t, VertexId a, VertexId b) {
  constexpr int kTries = 8;
  const SplitBounds bounds{
      .shortest = w.kernel.limits.finest_split_shortest, .keep_share = 0.1, .on_chord = true};
  VertexId made;
  Verdict r = split_edge(w, t, a, b, bounds, &made);
  w.claims.release();
  if (r != Verdict::accepted) return r;
  const auto again = [](Verdict x) { return x == Verdict::inverts || x == Verdict::conflict; };
  r = Verdict::inverts;
  for (int i = 0; i < kTries && again(r); ++i) {
    if (i > 0) make_room(w, made);
    r = raise_vertex(w, made);
    w.claims.release();
  }
  if (r == Verdict::accepted) return r;
  for (int i = 0; i < kTries && take_back(w, made, a, b) == Verdict::conflict; ++i) continue;
  return Verdict::inverts;
}

/// A tet at both vertices, claimed with the ball of `a`; invalid, and nothing claimed, where there is none,
/// or others hold them.
TetId claim_tet_at(Worker& w, VertexId a, VertexId b) {
  if (gather_ball(w.mesh, w.claims, a, w.ball) == Verdict::accepted)
    for (const auto& [t, local] : w.ball.tets)
      if (w.mesh.local_index(t, b) >= 0) return t;
  w.claims.release();
  return {};
}

/// Gives up one of the vertices inside around an edge of the claimed tet, the one nearest to its middle that
/// can go. False where none can. Claims nothing in the end.
bool clear_ring(Worker& w, TetId t, VertexId a, VertexId b) {
  std::vector<std::pair<double, VertexId>> inside;
  const Verdict r = gather_shell(w.mesh, w.claims, t, a, b, w.shell);
  const Point middle = midpoint(w.mesh.point(a), w.mesh.point(b));
  const int size = w.shell.closed ? w.shell.size : w.shell.size + 1;
  for (int i = 0; r == Verdict::accepted && i < size; ++i)
    if (const VertexId u = w.shell.ring[i]; w.mesh.kind(u) == VertexKind::interior)
      inside.emplace_back(norm2(w.mesh.point(u) - middle), u);
  w.claims.release();
  std::sort(inside.begin(), inside.end());
  return std::any_of(inside.begin(), inside.end(), [&](const auto& u) {
    return collapse_vertex(w, u.second, kUnbounded, CollapseGoal::room) == Verdict::accepted;
  });
}

/// Splits an edge of boundary on a model where vertices that cannot move stand between it and the surface:
/// they are given up one by one, until it can be split or a vertex can rise from it. Counts the splits that
/// it has tried in vain, and claims nothing in the end.
Verdict split_after_clearing(Worker& w, VertexId a, VertexId b) {
  constexpr int kMost = 12;
  for (int i = 0; i < kMost; ++i) {
    TetId t = claim_tet_at(w, a, b);
    if (!t.valid() || !clear_ring(w, t, a, b)) break;
    for (const bool below : {false, true}) {
      t = claim_tet_at(w, a, b);
      if (!t.valid()) return Verdict::inverts;
      const Verdict r = below ? split_below(w, t, a, b)
                              : split_edge(w, t, a, b, {w.kernel.limits.finest_split_shortest, 0.1});
      w.claims.release();
      if (r == Verdict::accepted || r == Verdict::conflict) return r;
      w.counts.add(Operator::split, r);
    }
  }
  return Verdict::inverts;
}

/// Boundary edges that curve come first, whatever the level: they must be resolved while the tets on them are
/// still thick, and before anything is created between them and the surface.
Verdict split_curved(Worker& w, TetId t, const TetVertices& v) {
  const Limits& limits = w.kernel.limits;
  std::array<std::array<VertexId, 2>, 12> behind;
  std::size_t refused = 0;
  for (int f = 0; f < 4; ++f) {
    const PatchId patch = w.mesh.patch(t, f);
    if (!patch.valid() || w.kernel.surface.patches()[patch.value].planar) continue;
    for (int i = 0; i < 3; ++i) {
      const VertexId a = v[kTetFaces[f][i]], b = v[kTetFaces[f][(i + 1) % 3]];
      if (!curves_too_much(w.kernel, a, b, patch)) continue;
      Verdict r = split_edge(w, t, a, b, {limits.finest_split_shortest});
      if (r == Verdict::too_short && limits.shortest_at_curved < limits.finest_split_shortest &&
          length_between(w.mesh, a, b) > limits.finest_long_edge) {
        w.counts.add(Operator::split, r);
        r = split_edge(w, t, a, b, {limits.shortest_at_curved});
      }
      if (r == Verdict::accepted || r == Verdict::conflict) return r;
      w.counts.add(Operator::split, r);
      if (r == Verdict::inverts || r == Verdict::worsens_quality) behind[refused++] = {a, b};
    }
  }
  for (std::size_t i = 0; i < refused && w.kernel.policy.allowed.move; ++i) {
    Verdict r = split_below(w, t, behind[i][0], behind[i][1]);
    if (r == Verdict::inverts && w.kernel.surface.model())
      r = split_after_clearing(w, behind[i][0], behind[i][1]);
    if (r == Verdict::accepted || r == Verdict::conflict || !w.mesh.alive(t)) return r;
    if (const Verdict claimed = w.claims.claim_tet(t); claimed != Verdict::accepted) return claimed;
    if (w.mesh.vertices(t) != v) return r;
    w.counts.add(Operator::split, r);
  }
  return w.mesh.all_on_curved_boundary(v) ? split_lying(w, t, v) : Verdict::not_needed;
}

bool on_boundary(const TetMesh& mesh, const TetVertices& v) {
  return std::count_if(v.begin(), v.end(), [&](VertexId x) { return mesh.kind(x) != VertexKind::interior; }) >
         1;
}

/// Whether edges are split to the wanted lengths now, not to those of a coarser level.
bool is_finest(const Limits& limits) { return limits.long_edge <= limits.finest_long_edge; }

/// What is refused from one tet of the gathered shell is refused from all of them, until something there
/// changes.
void remember_refused(Worker& w) {
  for (int i = 0; i < w.shell.size; ++i) {
    const Shell::Entry& e = w.shell.tets[i];
    w.mesh.set_refused_edge(e.tet, kEdgeOf[e.a][e.b]);
  }
}

/// Tries the edges beyond the level's limit, longest first.
Verdict split_beyond_limit(Worker& w, TetId t, const TetVertices& v) {
  const Limits& limits = w.kernel.limits;
  const LongEdges found = edges_above(limits.long_edge, w.mesh, v);
  Verdict r = Verdict::not_needed;
  for (int i = found.size - 1; i >= 0; --i) {
    const auto& [edge, length] = found.edges[i];
    if (edge == w.mesh.refused_edge(t)) continue;
    const auto& e = kTetEdges[edge];
    // What is round an edge far too long would protect it for ever: vertices that crowd there, with which the
    // new one may merge later; needles, of which shorter ones must be made before anything can be mended. On
    // the boundary, needles keep fine parts of it from being given up at coarse levels: only the last one
    // makes them there.
    SplitBounds bounds{limits.split_shortest};
    if (length > 2 * limits.long_edge) {
      bounds.shortest *= 0.1;
      const auto inside = [&](VertexId u) { return w.mesh.kind(u) == VertexKind::interior; };
      if (is_finest(limits) || (inside(v[e[0]]) && inside(v[e[1]]))) bounds.quality_share = 0.1;
    }
    r = split_edge(w, t, v[e[0]], v[e[1]], bounds);
    if (r == Verdict::accepted || r == Verdict::conflict) break;
    w.counts.add(Operator::split, r);
    remember_refused(w);
  }
  return r;
}

Verdict split_longest(Worker& w, TetId t) {
  const Limits& limits = w.kernel.limits;
  if (const Verdict r = w.claims.claim_tet(t); r != Verdict::accepted) return done(w, Operator::split, r);
  const TetVertices v = w.mesh.vertices(t);
  const bool boundary = on_boundary(w.mesh, v);
  if (boundary)
    if (const Verdict r = split_curved(w, t, v); r != Verdict::not_needed) return done(w, Operator::split, r);
  const Verdict r = split_beyond_limit(w, t, v);
  if (r != Verdict::accepted && !is_finest(limits) &&
      (boundary || has_edge_above(limits.finest_long_edge, w.mesh, v)))
    w.mesh.mark(t, kLongLater);
  if (r == Verdict::not_needed || r == Verdict::accepted || r == Verdict::conflict)
    return done(w, Operator::split, r);
  w.claims.release();
  return r;
}

// Two tets become three only where they are poor: of two million tries on cube-polar2 to 50,000 a thousand
// were done, and they left the least quality lower (0.552 instead of 0.559).
constexpr double kFaceSwapsBelow = 0.3;

/// Swaps one edge or face of the tet, the first that helps.
Verdict swap_any(Worker& w, TetId t) {
  Verdict r = w.claims.claim_tet(t);
  if (r != Verdict::accepted) return done(w, Operator::swap_edge, r);
  const TetVertices v = w.mesh.vertices(t);
  std::array<bool, 4> left;  // to the tet across a face: with it the face's edges
  for (int f = 0; f < 4; ++f) {
    const TetFace n = w.mesh.neighbour(t, f);
    if (n.valid()) w.mesh.prefetch(n.tet());
    left[f] = n.valid() && leaves_swap_to(w.mesh, t, n.tet());
  }
  for (const auto& e : kTetEdges) {
    r = left[e[2]] || left[e[3]] ? Verdict::not_needed : swap_edge(w, t, v[e[0]], v[e[1]]);
    if (r == Verdict::accepted || r == Verdict::conflict) return done(w, Operator::swap_edge, r);
    w.counts.add(Operator::swap_edge, r);
  }
  const bool poor = w.mesh.quality(t) < kFaceSwapsBelow;
  for (int f = 0; poor && f < 4; ++f) {
    r = swap_face(w, t, f);
    if (r == Verdict::accepted || r == Verdict::conflict) return done(w, Operator::swap_face, r);
    w.counts.add(Operator::swap_face, r);
  }
  w.claims.release();
  return Verdict::worsens_quality;
}

/// Relocation and collapse look at whole balls: what does not help one poor tet of a ball helps none of them,
/// and is not tried again until the ball changes (a torus with strong shear across its surface, 36,000 tets:
/// 1.5 s of improvement instead of 2.7, the same mesh).
Verdict collapse_any(Worker& w, TetId t) {
  if (!w.mesh.alive(t)) return Verdict::not_needed;
  for (const VertexId v : w.mesh.vertices(t)) {
    if (w.mesh.marks(v) & kStuck) continue;
    const Verdict r = collapse_vertex(w, v, w.kernel.limits.long_edge, CollapseGoal::quality);
    if (r == Verdict::accepted || r == Verdict::conflict) return r;
    if (r != Verdict::frozen) w.mesh.mark(v, kStuck);
  }
  return Verdict::worsens_quality;
}

Verdict relocate_any(Worker& w, TetId t) {
  if (!w.mesh.alive(t)) return Verdict::not_needed;
  Verdict r = Verdict::not_needed;
  for (const VertexId v : w.mesh.vertices(t)) {
    if (w.mesh.marks(v) & kStuck) continue;
    r = done(w, Operator::relocate, relocate_vertex(w, v));
    if (r == Verdict::accepted || r == Verdict::conflict) return r;
  }
  return Verdict::worsens_quality;
}

/// Splits an edge that is too long and that vertices crowd round: they kept it from being split for its
/// length, and collapse into the new one afterwards.
Verdict split_any(Worker& w, TetId t) {
  constexpr double kShortest = 0.25;
  const Limits& limits = w.kernel.limits;
  if (const Verdict r = w.claims.claim_tet(t); r != Verdict::accepted) return done(w, Operator::split, r);
  const TetVertices v = w.mesh.vertices(t);
  const LongEdges found = edges_above(limits.long_edge, w.mesh, v);
  for (int i = found.size - 1; i >= 0; --i) {
    const auto& e = kTetEdges[found.edges[i].edge];
    const Verdict r = split_edge(w, t, v[e[0]], v[e[1]], {.shortest = kShortest, .must_improve = true});
    if (r == Verdict::accepted || r == Verdict::conflict) return done(w, Operator::split, r);
    w.counts.add(Operator::split, r);
  }
  w.claims.release();
  return Verdict::worsens_quality;
}

/// Puts a vertex among the tets round an inner edge, where they are best: of a tet whose other vertices lie
/// on the boundary, on which none can be moved or given up, that is all that helps.
Verdict insert_any(Worker& w, TetId t) {
  constexpr double kShortest = 0.35;
  if (const Verdict r = w.claims.claim_tet(t); r != Verdict::accepted) return done(w, Operator::split, r);
  const TetVertices v = w.mesh.vertices(t);
  for (const auto& e : kTetEdges) {
    const Verdict r =
        split_edge(w, t, v[e[0]], v[e[1]], {.shortest = kShortest, .must_improve = true, .at_best = true});
    if (r == Verdict::accepted || r == Verdict::conflict) return done(w, Operator::split, r);
    w.counts.add(Operator::split, r);
  }
  w.claims.release();
  return Verdict::worsens_quality;
}

Verdict improve(Worker& w, TetId t, double quality) {
  if (!w.mesh.alive(t) || w.mesh.quality(t) >= quality) return Verdict::not_needed;
  const AllowedOperations& may = w.kernel.policy.allowed;
  for (const auto& [allowed, operation] :
       {std::pair(may.swap, &swap_any), std::pair(may.move, &relocate_any),
        std::pair(may.insert, &collapse_any), std::pair(may.insert, &split_any),
        std::pair(may.insert, &insert_any)}) {
    if (!allowed) continue;
    if (const Verdict r = operation(w, t); r == Verdict::accepted || r == Verdict::conflict) return r;
  }
  return Verdict::worsens_quality;
}

}  // namespace

std::uint64_t snap_pass(WorkerPool& pool) {
  if (!pool.allowed().move) return 0;
  std::atomic<std::uint64_t> off{0};
  pool.sweep_all_vertices([&](Worker& w, VertexId v) {
    if (w.mesh.kind(v) == VertexKind::interior) return Verdict::not_needed;
    constexpr int kTries = 3;
    Verdict r = Verdict::inverts;
    for (int i = 0; i < kTries && r == Verdict::inverts; ++i) {
      if (i > 0) make_room(w, v);
      r = snap_vertex(w, v);
      w.claims.release();
    }
    if (r == Verdict::inverts || r == Verdict::conflict) ++off;
    return r;
  });
  return off;
}

std::uint64_t resolve_curved_pass(WorkerPool& pool) {
  if (!pool.allowed().insert) return 0;
  return pool.sweep_tets(kCheckLong, [](Worker& w, TetId t) {
    Verdict r = w.claims.claim_tet(t);
    if (r == Verdict::accepted) {
      w.mesh.mark(t, kCheckLong);
      const TetVertices v = w.mesh.vertices(t);
      r = on_boundary(w.mesh, v) ? split_curved(w, t, v) : Verdict::not_needed;
    }
    return done(w, Operator::split, r);
  });
}

std::uint64_t split_pass(WorkerPool& pool) {
  if (!pool.allowed().insert) return 0;
  return pool.sweep_tets(kCheckLong, [](Worker& w, TetId t) {
    const Verdict r = split_longest(w, t);
    // The pass is made once more where a mesh that is full can grow.
    if (r != Verdict::accepted && r != Verdict::not_needed && w.mesh.is_full() && w.mesh.alive(t))
      w.mesh.mark(t, kCheckLong);
    return r;
  });
}

std::uint64_t collapse_pass(WorkerPool& pool) {
  if (!pool.allowed().insert) return 0;
  return pool.sweep_vertices(kCheckShort, [](Worker& w, VertexId v, std::uint8_t) {
    return collapse_vertex(w, v, w.kernel.limits.short_edge, CollapseGoal::length);
  });
}

std::uint64_t swap_pass(WorkerPool& pool, double quality, double quality_at_frozen) {
  if (!pool.allowed().swap) return 0;
  return pool.sweep_tets(kCheckSwap, [quality, quality_at_frozen](Worker& w, TetId t) {
    if (!w.mesh.alive(t) || w.mesh.quality(t) >= quality) return Verdict::not_needed;
    if (w.mesh.quality(t) >= quality_at_frozen && w.mesh.has_frozen(t)) return Verdict::not_needed;
    return swap_any(w, t);
  });
}

std::uint64_t smooth_pass(WorkerPool& pool) {
  if (!pool.allowed().move) return 0;
  return pool.sweep_vertices(kCheckPlace, [](Worker& w, VertexId v, std::uint8_t) {
    return done(w, Operator::smooth, smooth_vertex(w, v));
  });
}

std::uint64_t smooth_and_collapse_pass(WorkerPool& pool) {
  if (!pool.allowed().insert) return smooth_pass(pool);
  if (!pool.allowed().move) return collapse_pass(pool);
  return pool.sweep_vertices(kCheckPlace | kCheckShort, smooth_and_collapse);
}

std::uint64_t smooth_poor(WorkerPool& pool, double quality) {
  if (!pool.allowed().move) return 0;
  return pool.sweep_tets(kCheckSwap, [quality](Worker& w, TetId t) {
    if (!w.mesh.alive(t) || w.mesh.quality(t) >= quality) return Verdict::not_needed;
    Verdict any = Verdict::not_needed;
    for (const VertexId v : w.mesh.vertices(t))
      if (done(w, Operator::smooth, smooth_vertex(w, v)) == Verdict::accepted) any = Verdict::accepted;
    return any;
  });
}

std::uint64_t improve_pass(WorkerPool& pool, double quality) {
  return pool.sweep_tets(kCheckPoor, [quality](Worker& w, TetId t) { return improve(w, t, quality); });
}

}  // namespace weft::meshing
