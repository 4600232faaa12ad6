// Edge split: place, judge, commit.
#include "meshing/operators/split_edge.h"

#include <algorithm>

#include "meshing/operators/best_place.h"
#include "meshing/operators/check_cavity.h"

namespace weft::meshing {
namespace {

/// A vertex to be created.
struct NewVertex {
  Point x;
  LogMetric log_metric;
  Metric metric;
  EdgeClass on;
  std::uint32_t background_hint, surface_hint = 0;
  Vec normal = {};  ///< of the surface there, where that is curved
};

void read_metric(const Worker& w, std::uint32_t hint, NewVertex& n) {
  const Background::Sample sample = w.kernel.background.at(n.x, hint);
  n.log_metric = sample.log_metric;
  n.metric = exp_fast(n.log_metric);
  n.background_hint = sample.tet;
}

NewVertex place(const Worker& w, VertexId a, VertexId b, const EdgeClass& on, bool on_chord) {
  const TetMesh& mesh = w.mesh;
  const Point &pa = mesh.point(a), &pb = mesh.point(b);
  const Vec e = pb - pa;
  const double la = std::sqrt(squared_length(mesh.metric(a), e)),
               lb = std::sqrt(squared_length(mesh.metric(b), e));
  // Equal coordinates stay equal exactly: axis-aligned planes keep their points.
  NewVertex n{pa + metric_middle(la, lb) * e, {}, {}, on, 0, 0};
  const Surface& s = w.kernel.surface;
  if (on.kind == VertexKind::ridge) {
    const auto q = s.project_to_curve(on.curve, n.x, mesh.kind(a), mesh.surface_hint(a));
    if (!on_chord && !s.curves()[on.curve.value].straight) n.x = q.x;
    n.surface_hint = q.hint;
  } else if (on.kind == VertexKind::surface) {
    const auto q = s.project_to_patch(on.patch, n.x, mesh.kind(a), mesh.surface_hint(a));
    if (!on_chord && !s.patches()[on.patch.value].planar) n.x = q.x;
    n.surface_hint = q.hint;
    n.normal = q.normal;
  }
  read_metric(w, mesh.background_hint(a), n);
  return n;
}

/// Moves the vertex of an inner edge, whose shell is gathered, to where the worst of its tets is best.
/// Refuses where it is there already, and boundary.
Verdict move_to_best(Worker& w, NewVertex& n) {
  const Shell& shell = w.shell;
  const int tets = 2 * shell.size;  // each one leaves two: with the new vertex for one end, and for the other
  if (n.on.kind != VertexKind::interior) return Verdict::not_needed;
  if (tets > kMostFaces) return Verdict::too_large;
  w.ball.tets.clear();
  w.ball.tets.make_room(static_cast<std::size_t>(tets));
  for (int i = 0; i < shell.size; ++i)
    for (const int end : {shell.tets[i].a, shell.tets[i].b})
      w.ball.tets.push_if(true, {shell.tets[i].tet, end});
  w.faces.gather(w.mean(), w.mesh, w.ball);
  const auto x = best_place(w.faces, n.x, n.metric, judge_tensor(w.mean(), n.metric, n.log_metric));
  if (!x) return Verdict::not_needed;
  n.x = *x;
  read_metric(w, n.background_hint, n);
  return Verdict::accepted;
}

/// What a split does: every tet of the shell becomes two.
struct SplitPlan {
  const Shell& shell;
  const NewVertex& vertex;
  std::span<const float> qualities;        ///< of the two tets that each one becomes: at a, at b
  std::span<const Neighbour> short_edges;  ///< new ones at the vertex
};

/// The vertices of the ring that the new one is near to, for `plan`. One that is put where it is best may be
/// near the edge's ends as well, and is wanted though its edges are short.
Verdict judge_lengths(Worker& w, const SplitBounds& bounds, SplitPlan& plan) {
  const TetMesh& mesh = w.mesh;
  const NewVertex& n = plan.vertex;
  const Shell& shell = plan.shell;
  w.short_edges.clear();
  const auto judge_to = [&](VertexId v) {
    const Vec e = mesh.point(v) - n.x;
    const MetricLength length{squared_length(mesh.metric(v), e), squared_length(n.metric, e)};
    if (length.below(bounds.shortest)) return Verdict::too_short;
    if (!bounds.at_best && length.below(w.kernel.limits.short_edge))
      w.short_edges.push_back({v, length.value()});
    return Verdict::accepted;
  };
  const int ring_size = shell.closed ? shell.size : shell.size + 1;
  for (int i = 0; i < ring_size; ++i)
    if (const Verdict r = judge_to(shell.ring[i]); r != Verdict::accepted) return r;
  if (bounds.at_best)
    for (const VertexId end : {shell.a, shell.b})
      if (const Verdict r = judge_to(end); r != Verdict::accepted) return r;
  plan.short_edges = w.short_edges;
  return Verdict::accepted;
}

/// The qualities of the tets that a split would leave, for `plan`, as long as is_enough(the worse of two).
template <class IsEnough>
Verdict judge_qualities(Worker& w, SplitPlan& plan, const IsEnough& is_enough) {
  const Shell& shell = plan.shell;
  const NewVertex& n = plan.vertex;
  const MetricMean mean = w.mean();
  const Corner a = w.corner(shell.a), b = w.corner(shell.b),
               p{n.x, judge_tensor(mean, n.metric, n.log_metric)};
  w.qualities.clear();
  for (int i = 0; i < shell.size; ++i) {
    const Corner r = w.corner(shell.ring[i]), s = w.corner(shell.ring[i + 1]);
    const double qa = judge_quality(mean, a, p, r, s), qb = judge_quality(mean, p, b, r, s);
    if (qa < 0 || qb < 0) return Verdict::inverts;
    if (!is_enough(std::min(qa, qb))) return Verdict::worsens_quality;
    w.qualities.push_back(static_cast<float>(qa));
    w.qualities.push_back(static_cast<float>(qb));
  }
  plan.qualities = w.qualities;
  return Verdict::accepted;
}

/// Would a triangle of a curved patch stand on the surface or turn over, its normal turned by more than 60
/// degrees from that of the surface at the new vertex, which the triangle that is split does not?
bool bends_surface(const Worker& w, const SplitPlan& plan) {
  const NewVertex& n = plan.vertex;
  const Shell& shell = plan.shell;
  if (n.on.kind != VertexKind::surface || w.kernel.surface.patches()[n.on.patch.value].planar) return false;
  const Point &a = w.mesh.point(shell.a), &b = w.mesh.point(shell.b);
  const auto cosine = [&](const Point& x, const Point& y, const Point& z) {
    const Vec normal = cross(y - x, z - x);
    return dot(normal, n.normal) / norm(normal);
  };
  for (const VertexId r : {shell.ring[0], shell.ring[shell.size]}) {
    const Point& c = w.mesh.point(r);
    const double before = cosine(a, b, c), side = before < 0 ? -1 : 1;
    if (std::abs(before) < 0.5) continue;
    if (side * cosine(a, n.x, c) < 0.5 || side * cosine(n.x, b, c) < 0.5) return true;
  }
  return false;
}

/// Accepted: `plan` is complete.
Verdict judge(Worker& w, const SplitBounds& bounds, SplitPlan& plan) {
  if (const Verdict r = judge_lengths(w, bounds, plan); r != Verdict::accepted) return r;
  if (!plan.shell.closed && bends_surface(w, plan)) return Verdict::leaves_surface;
  double worst_before = 1;
  for (int i = 0; i < plan.shell.size; ++i)
    worst_before = std::min<double>(worst_before, w.mesh.quality(plan.shell.tets[i].tet));
  const double bound =
      std::min(bounds.quality_share * w.kernel.limits.split_quality, bounds.keep_share * worst_before);
  return judge_qualities(
      w, plan, [&](double worst) { return bounds.must_improve ? worst > worst_before : worst >= bound; });
}

/// All that matters where the caller decides: no tet is lost.
Verdict judge_positive(Worker& w, SplitPlan& plan) {
  return judge_qualities(w, plan, [](double) { return true; });
}

/// Writes the new vertex into slot `p`.
void create(Worker& w, VertexId p, const NewVertex& n, const Shell& shell) {
  TetMesh& mesh = w.mesh;
  mesh.set_point(p, n.x);
  mesh.set_metric(p, n.log_metric, n.metric);
  mesh.set_kind(p, n.on.kind);
  mesh.set_flags(
      p, n.on.kind == VertexKind::interior ? 0 : mesh.flags(shell.a) & mesh.flags(shell.b) & kOnCurved);
  mesh.set_ref(p, 0);
  mesh.set_label(p, 0);
  mesh.set_background_hint(p, n.background_hint);
  mesh.set_surface_hint(p, n.surface_hint);
  if (n.on.kind == VertexKind::ridge) mesh.divide_curve(shell.a, p, shell.b, n.on.curve);
}

void commit(Worker& w, const SplitPlan& plan, VertexId p) {
  TetMesh& mesh = w.mesh;
  const Shell& shell = plan.shell;
  std::array<TetId, Shell::kMaxSize> upper;
  for (int i = 0; i < shell.size; ++i) {
    // The old tet keeps a and becomes (a, p, r, s); the new one is (p, b, r, s) in the same local places.
    const auto& [t, ia, ib, ir, is] = shell.tets[i];
    const TetId u = upper[i] = w.new_tet();
    TetVertices v = mesh.vertices(t);
    v[ia] = p;
    mesh.set_vertices(u, v);
    mesh.set_vertex(t, ib, p);
    mesh.set_ref(u, mesh.ref(t));
    mesh.glue(TetFace(u, ia), mesh.neighbour(t, ia));
    mesh.set_patch(u, ia, mesh.patch(t, ia));
    mesh.set_patch(u, ib, PatchId());
    mesh.set_patch(u, ir, mesh.patch(t, ir));
    mesh.set_patch(u, is, mesh.patch(t, is));
    mesh.set_patch(t, ia, PatchId());
    mesh.glue(TetFace(t, ia), TetFace(u, ib));
    mesh.set_quality(t, plan.qualities[2 * i]);
    mesh.set_quality(u, plan.qualities[2 * i + 1]);
    mesh.mark(t, kAllTetMarks);
    mesh.mark(u, kAllTetMarks);
    mesh.touch(shell.ring[i]);
  }
  for (int i = 0; i < shell.size; ++i) {
    const int next = i + 1 < shell.size ? i + 1 : 0;
    if (next > 0 || shell.closed)
      mesh.glue(TetFace(upper[i], shell.tets[i].r), TetFace(upper[next], shell.tets[next].s));
  }
  if (!shell.closed) {
    mesh.set_neighbour(upper[0], shell.tets[0].s, TetFace());
    mesh.set_neighbour(upper[shell.size - 1], shell.tets[shell.size - 1].r, TetFace());
    mesh.touch(shell.ring[shell.size]);
  }
  mesh.set_tet_of(p, upper[0]);
  mesh.set_tet_of(shell.b, upper[0]);
  for (VertexId v : {shell.a, shell.b, p}) mesh.touch(v);
  for (const Neighbour& n : plan.short_edges) {
    mesh.mark(n.vertex, kCheckShort);
    mesh.mark(p, kCheckShort);
  }
}

}  // namespace

VertexId split_edge_at(Worker& w, VertexId a, VertexId b, std::span<const TetId> fans,
                       const VertexOnEdge& at) {
  EdgeClass on;
  on.kind = at.kind;
  on.curve = at.curve;
  const NewVertex n{at.x, at.log_metric, exp_fast(at.log_metric), on, at.background_hint, at.surface_hint};
  SplitPlan plan{w.shell, n, {}, {}};  // of one fan at a time
  const auto judge_fan = [&](TetId t) {
    return gather_shell(w.mesh, w.claims, t, a, b, w.shell) == Verdict::accepted &&
           judge_positive(w, plan) == Verdict::accepted;
  };
  std::size_t tets = 0;
  for (const TetId t : fans) {
    if (!judge_fan(t)) return {};
    tets += static_cast<std::size_t>(w.shell.size);
  }
  if (!w.secure(tets, 1)) return {};
  const VertexId p = w.new_vertex();
  if (!p.valid()) return {};
  create(w, p, n, w.shell);
  for (const TetId t : fans) {
    if (fans.size() > 1) judge_fan(t);  // else it is at hand
    commit(w, plan, p);
  }
  // No check of the cavity: its faces without neighbour are rightly so only once the caller has frozen `p`.
  return p;
}

double metric_middle(double la, double lb) {
  const double ratio = lb / la;
  if (!(std::abs(ratio - 1) >= 1e-3 && ratio > 0 && std::isfinite(ratio))) return 0.5;
  return std::clamp(std::log(0.5 * (1 + ratio)) / std::log(ratio), 0.2, 0.8);
}

Verdict split_edge(Worker& w, TetId t, VertexId a, VertexId b, const SplitBounds& bounds, VertexId* made) {
  if (const Verdict r = gather_shell(w.mesh, w.claims, t, a, b, w.shell); r != Verdict::accepted) return r;
  if (incomplete(w.mesh, w.shell)) return Verdict::frozen;
  const EdgeClass on = classify(w.mesh, w.shell);
  if (on.curve.valid() && w.kernel.surface.curves()[on.curve.value].required) return Verdict::required;
  NewVertex n = place(w, a, b, on, bounds.on_chord);
  if (bounds.at_best)
    if (const Verdict r = move_to_best(w, n); r != Verdict::accepted) return r;
  SplitPlan plan{w.shell, n, {}, {}};
  if (const Verdict r = judge(w, bounds, plan); r != Verdict::accepted) return r;
  if (!w.secure(static_cast<std::size_t>(w.shell.size), 1)) return Verdict::too_large;
  const VertexId p = w.new_vertex();
  if (!p.valid()) return Verdict::conflict;
  create(w, p, n, w.shell);
  commit(w, plan, p);
  check_cavity(w, p);
  if (made) *made = p;
  return Verdict::accepted;
}

}  // namespace weft::meshing
