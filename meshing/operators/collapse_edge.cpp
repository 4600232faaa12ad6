// Edge collapse: classification, link, lengths, qualities, commit.
#include "meshing/operators/collapse_edge.h"

#include <algorithm>
#include <span>

#include "meshing/base/assert.h"
#include "meshing/operators/check_cavity.h"
#include "meshing/operators/surface_fit.h"

namespace weft::meshing {
namespace {

/// What a collapse does: the ball's centre goes to `kept`.
struct CollapsePlan {
  const Ball& ball;
  VertexId kept;
  EdgeClass edge;                          ///< of the boundary, if the centre lies there
  std::span<const float> qualities;        ///< of the ball's tets afterwards; negative for those that vanish
  std::span<const Neighbour> short_edges;  ///< new ones at `kept`

  VertexId removed() const { return ball.centre; }
};

/// May `removed` go to the other end of the edge without losing a corner, ridge, patch or interface?
Verdict judge_classification(const Worker& w, const EdgeClass& edge, VertexId removed) {
  const VertexKind kind = w.mesh.kind(removed);
  if (w.mesh.fixed(removed)) return Verdict::required;
  if (w.mesh.frozen(removed)) return Verdict::frozen;
  if (kind == VertexKind::interior) return Verdict::accepted;
  if (kind == VertexKind::corner || kind != edge.kind) return Verdict::breaks_classification;
  if (edge.curve.valid() && w.kernel.surface.curves()[edge.curve.value].required) return Verdict::required;
  return Verdict::accepted;
}

using LinkEdge = std::pair<VertexId, VertexId>;

/// The edges of the link of a ball's centre between vertices of `ring`, those of tets that have `other` left
/// out.
void link_edges_in(const TetMesh& mesh, const Ball& ball, VertexId other, const SmallSet& ring,
                   std::vector<LinkEdge>& edges) {
  edges.clear();
  for (const auto& [t, local] : ball.tets) {
    if (mesh.local_index(t, other) >= 0) continue;
    for (const int i : kTetFaces[local])
      for (const int j : kTetFaces[local]) {
        const VertexId x = mesh.vertex(t, i), y = mesh.vertex(t, j);
        if (x < y && ring.contains(x.value) && ring.contains(y.value)) edges.emplace_back(x, y);
      }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

/// Calls visit(x, y) for the two other vertices of every face of the ball that lies on a patch and at its
/// centre.
template <class Visit>
void for_patch_faces(const TetMesh& mesh, const Ball& ball, Visit visit) {
  for (const auto& [t, local] : ball.tets)
    for (int f = 0; f < 4; ++f) {
      if (f == local || !mesh.patch(t, f).valid()) continue;
      const int i = (f + 1) % 4 == local ? (f + 2) % 4 : (f + 1) % 4, j = 6 - f - local - i;
      visit(mesh.vertex(t, i), mesh.vertex(t, j));
    }
}

/// The boundary's part of the link condition, for the surface that boundary and interfaces are: a vertex that
/// surface edges join to both ends must do so across a surface triangle of all three. Otherwise the two edges
/// become one with four surface triangles, and the body hangs together by an edge there. Both balls are
/// gathered; `across` and `joined` are scratch.
bool pinches_surface(const Worker& w, VertexId removed, VertexId kept, SmallSet& across, SmallSet& joined) {
  across.clear();
  joined.clear();
  for_patch_faces(w.mesh, w.ball, [&](VertexId x, VertexId y) {
    if (x == kept || y == kept)
      across.insert((x == kept ? y : x).value);
    else
      for (const VertexId v : {x, y}) joined.insert(v.value);
  });
  bool pinches = false;
  for_patch_faces(w.mesh, w.other_ball, [&](VertexId x, VertexId y) {
    if (x == removed || y == removed) return;
    for (const VertexId v : {x, y}) pinches |= joined.contains(v.value) && !across.contains(v.value);
  });
  return pinches;
}

/// Link condition (Dey et al. 1999) for boundary vertices: vertices and edges in the links of both ends are
/// in the link of their edge, so that nothing comes to exist twice. For interior vertices the exactly
/// positive tets imply it, but where room is made below a chord of the boundary: there the mesh may overlap
/// itself. The boundary may close up over a gap.
Verdict judge_link(Worker& w, VertexId removed, VertexId kept) {
  const TetMesh& mesh = w.mesh;
  if (mesh.frozen(kept)) return Verdict::frozen;  // its ball is not all here
  if (const Verdict r = gather_ball(w.mesh, w.claims, kept, w.other_ball); r != Verdict::accepted) return r;
  SmallSet &link = w.vertices_seen, &ring = w.other_ball.seen;  // the latter is free now
  link.clear();
  ring.clear();
  std::vector<LinkEdge> shell_edges;
  for (const auto& [t, local] : w.ball.tets) {
    const int k = mesh.local_index(t, kept);
    std::array<VertexId, 2> opposite;
    for (int i = 0, n = 0; i < 4; ++i) {
      if (i == local || i == k) continue;
      (k >= 0 ? ring : link).insert(mesh.vertex(t, i).value);
      if (k >= 0) opposite[n++] = mesh.vertex(t, i);
    }
    if (k >= 0) shell_edges.push_back(std::minmax(opposite[0], opposite[1]));
  }
  for (const auto& [t, local] : w.other_ball.tets) {
    if (mesh.local_index(t, removed) >= 0) continue;
    for (const int i : kTetFaces[local])
      if (const VertexId v = mesh.vertex(t, i); link.contains(v.value) && !ring.contains(v.value))
        return Verdict::breaks_topology;
  }
  std::vector<LinkEdge> of_removed, of_kept;
  link_edges_in(mesh, w.ball, kept, ring, of_removed);
  link_edges_in(mesh, w.other_ball, removed, ring, of_kept);
  for (const LinkEdge& e : of_removed)
    if (std::binary_search(of_kept.begin(), of_kept.end(), e) &&
        std::find(shell_edges.begin(), shell_edges.end(), e) == shell_edges.end())
      return Verdict::breaks_topology;
  return pinches_surface(w, removed, kept, link, ring) ? Verdict::breaks_topology : Verdict::accepted;
}

/// The longest edge at the centre of the gathered ball.
double longest_spoke(Worker& w) {
  double longest = 0;
  for (const auto& [v, first] : w.ball.link)
    longest = std::max(longest, length_between(w.mesh, w.ball.centre, v));
  return longest;
}

/// The vertices of the ring around the edge from the ball's centre to `kept`, and its ends.
void gather_ring(Worker& w, VertexId kept, SmallSet& ring) {
  ring.clear();
  for (const auto& [t, local] : w.ball.tets)
    if (w.mesh.local_index(t, kept) >= 0)
      for (const VertexId v : w.mesh.vertices(t)) ring.insert(v.value);
}

/// Lengths of the edges that would appear: from `kept` to the link of `removed` beyond their ring. The short
/// ones are listed in `plan`. Nine of ten collapses are refused here: the ring is gathered when it is needed.
Verdict judge_lengths(Worker& w, CollapseGoal goal, CollapsePlan& plan) {
  const VertexId kept = plan.kept;
  const TetMesh& mesh = w.mesh;
  if (goal == CollapseGoal::undo || goal == CollapseGoal::room) return Verdict::accepted;
  const double longest = goal == CollapseGoal::quality
                             ? std::max(w.kernel.limits.collapse_longest, longest_spoke(w))
                             : w.kernel.limits.collapse_longest;
  SmallSet& ring = w.vertices_seen;
  bool has_ring = false;
  w.short_edges.clear();
  for (const auto& [v, first] : w.ball.link) {
    if (v == kept) continue;
    const MetricLength length = edge_between(mesh, v, kept);
    const bool too_long = length.above(longest);
    if (!too_long && !length.below(w.kernel.limits.short_edge)) continue;
    if (!has_ring) gather_ring(w, kept, ring);
    has_ring = true;
    if (ring.contains(v.value)) continue;
    if (too_long) return Verdict::too_long;
    w.short_edges.push_back({v, length.value()});
  }
  plan.short_edges = w.short_edges;
  return Verdict::accepted;
}

/// Qualities of the tets with `kept` in the place of `removed`, for `plan`.
Verdict judge_qualities(Worker& w, CollapseGoal goal, CollapsePlan& plan) {
  const VertexId kept = plan.kept;
  const TetMesh& mesh = w.mesh;
  double old_worst = 1;
  for (const auto& [t, local] : w.ball.tets) old_worst = std::min<double>(old_worst, mesh.quality(t));
  const double enough =
      goal == CollapseGoal::undo      ? 0
      : goal == CollapseGoal::room    ? std::min(w.kernel.limits.split_quality, 0.1 * old_worst)
      : goal == CollapseGoal::quality ? std::max(1.1 * old_worst, old_worst + 1e-3)
                                      : std::min(w.kernel.limits.collapse_quality, 0.9 * old_worst);
  const Corner k = w.corner(kept);
  w.qualities.clear();
  for (const auto& [t, local] : w.ball.tets) {
    if (mesh.local_index(t, kept) >= 0) {
      w.qualities.push_back(-1);
      continue;
    }
    const auto& f = kTetFaces[local];
    const double q = judge_quality_above(enough, w.mean(), w.corner(mesh.vertex(t, f[0])),
                                         w.corner(mesh.vertex(t, f[1])), w.corner(mesh.vertex(t, f[2])), k);
    if (q < 0) return Verdict::inverts;
    if (q <= enough) return Verdict::worsens_quality;
    w.qualities.push_back(static_cast<float>(q));
  }
  plan.qualities = w.qualities;
  return Verdict::accepted;
}

/// A tet that vanishes between two boundary faces, or a curve that closes on itself, would change the domain.
Verdict judge_topology(const Worker& w, VertexId removed, VertexId kept, const EdgeClass& edge) {
  const TetMesh& mesh = w.mesh;
  for (const auto& [t, local] : w.ball.tets) {
    const int k = mesh.local_index(t, kept);
    if (k >= 0 && mesh.patch(t, local).valid() && mesh.patch(t, k).valid()) return Verdict::breaks_topology;
    if (edge.kind != VertexKind::ridge) continue;
    for (const VertexId v : mesh.vertices(t))
      if (v != removed && v != kept && mesh.curve(removed, v).valid() && mesh.curve(kept, v).valid())
        return Verdict::breaks_topology;
  }
  return Verdict::accepted;
}

/// No tet may come to lie flat upon a curved surface (TetMesh::all_on_curved_boundary).
bool lies_down(const TetMesh& mesh, const Ball& ball, VertexId kept) {
  if (!(mesh.flags(kept) & kOnCurved)) return false;
  return std::any_of(ball.tets.begin(), ball.tets.end(), [&](const Ball::Entry& e) {
    if (mesh.local_index(e.tet, kept) >= 0) return false;
    TetVertices v = mesh.vertices(e.tet);
    v[e.local] = kept;
    return mesh.all_on_curved_boundary(v);
  });
}

/// On curved patches the new boundary triangles must stay near the reference surface and face the same way.
Verdict judge_surface(const Worker& w, VertexId kept) {
  const TetMesh& mesh = w.mesh;
  for (const auto& [t, local] : w.ball.tets) {
    if (mesh.local_index(t, kept) >= 0) continue;
    for (int f = 0; f < 4; ++f) {
      const PatchId patch = f == local ? PatchId() : mesh.patch(t, f);
      if (!patch.valid() || w.kernel.surface.patches()[patch.value].planar) continue;
      std::array<VertexId, 3> old, changed;
      for (int i = 0; i < 3; ++i) {
        old[i] = mesh.vertex(t, kTetFaces[f][i]);
        changed[i] = old[i] == w.ball.centre ? kept : old[i];
      }
      if (!fits_surface(w.kernel, patch, changed, old)) return Verdict::leaves_surface;
    }
  }
  return Verdict::accepted;
}

/// The tets that vanish hand the neighbour and patch of their face opposite `removed` to the tet across the
/// face opposite `kept`.
void close_gap(Worker& w, TetId t, int removed_local, int kept_local) {
  TetMesh& mesh = w.mesh;
  const TetFace outer = mesh.neighbour(t, removed_local), inner = mesh.neighbour(t, kept_local);
  const PatchId patch =
      mesh.patch(t, removed_local).valid() ? mesh.patch(t, removed_local) : mesh.patch(t, kept_local);
  mesh.glue(outer, inner);
  for (const TetFace f : {outer, inner})
    if (f.valid()) mesh.set_patch(f.tet(), f.face(), patch);
  const TetId home = outer.valid() ? outer.tet() : inner.tet();
  for (int i = 0; i < 4; ++i)
    if (i != removed_local) mesh.set_tet_of(mesh.vertex(t, i), home);
}

/// What may fail, for want of memory, comes before anything is changed.
void keep_feature(TetMesh& mesh, const CollapsePlan& plan) {
  if (plan.edge.kind != VertexKind::ridge) return;
  for (const auto& [t, local] : plan.ball.tets)
    for (int i = 0; i < 4; ++i) {
      const VertexId v = mesh.vertex(t, i);
      if (i == local || v == plan.kept || !mesh.curve(plan.removed(), v).valid()) continue;
      mesh.set_curve(plan.kept, v, plan.edge.curve);
      mesh.set_curve(plan.removed(), v, CurveId());
    }
  mesh.set_curve(plan.removed(), plan.kept, CurveId());
}

void commit(Worker& w, const CollapsePlan& plan) {
  TetMesh& mesh = w.mesh;
  const VertexId kept = plan.kept;
  w.prepare_to_free(plan.ball.tets.size(), 1);
  keep_feature(mesh, plan);
  for (const auto& [t, local] : plan.ball.tets)
    if (const int k = mesh.local_index(t, kept); k >= 0) close_gap(w, t, local, k);
  for (std::size_t i = 0; i < plan.ball.tets.size(); ++i) {
    const auto [t, local] = plan.ball.tets[i];
    if (plan.qualities[i] < 0) continue;
    mesh.set_vertex(t, local, kept);
    mesh.set_quality(t, plan.qualities[i]);
    mesh.mark(t, kAllTetMarks);
    for (const VertexId v : mesh.vertices(t)) {
      mesh.set_tet_of(v, t);
      mesh.touch(v);
    }
  }
  for (std::size_t i = 0; i < plan.ball.tets.size(); ++i)
    if (plan.qualities[i] < 0) w.free(plan.ball.tets[i].tet);
  w.free(plan.removed());
  for (const Neighbour& n : plan.short_edges) {
    mesh.mark(n.vertex, kCheckShort);
    mesh.mark(kept, kCheckShort);
  }
}

/// How the edge from the centre of the gathered ball to `kept` lies in the boundary.
Verdict classify_edge(Worker& w, CollapsePlan& plan) {
  const auto at = std::ranges::find_if(
      plan.ball.tets, [&](const Ball::Entry& e) { return w.mesh.local_index(e.tet, plan.kept) >= 0; });
  const Verdict r = gather_shell(w.mesh, w.claims, at->tet, plan.removed(), plan.kept, w.shell);
  if (r == Verdict::accepted) plan.edge = classify(w.mesh, w.shell);
  return r;
}

/// Accepted: `plan` is complete.
Verdict judge(Worker& w, CollapseGoal goal, CollapsePlan& plan) {
  const VertexId removed = plan.removed(), kept = plan.kept;
  const bool boundary = w.mesh.kind(removed) != VertexKind::interior;
  if (boundary)
    if (const Verdict r = classify_edge(w, plan); r != Verdict::accepted) return r;
  if (const Verdict r = judge_classification(w, plan.edge, removed); r != Verdict::accepted) return r;
  if (goal != CollapseGoal::undo && lies_down(w.mesh, w.ball, kept)) return Verdict::breaks_topology;
  if (const Verdict r = judge_lengths(w, goal, plan); r != Verdict::accepted) return r;
  if (const Verdict r = judge_qualities(w, goal, plan); r != Verdict::accepted) return r;
  if (!boundary) return goal == CollapseGoal::room ? judge_link(w, removed, kept) : Verdict::accepted;
  if (const Verdict r = judge_topology(w, removed, kept, plan.edge); r != Verdict::accepted) return r;
  if (goal != CollapseGoal::undo)
    if (const Verdict r = judge_surface(w, kept); r != Verdict::accepted) return r;
  return judge_link(w, removed, kept);
}

}  // namespace

Verdict collapse_edge(Worker& w, VertexId removed, VertexId kept, CollapseGoal goal) {
  WEFT_ASSERT_LIGHT(w.ball.centre == removed, "the ball of the removed vertex has been gathered");
  CollapsePlan plan{w.ball, kept, {}, {}, {}};
  const Verdict r = judge(w, goal, plan);
  if (r != Verdict::accepted) return r;
  commit(w, plan);
  check_cavity(w, kept);
  return Verdict::accepted;
}

}  // namespace weft::meshing
