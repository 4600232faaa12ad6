// Edge swap by the best triangulation of the ring.
#include "meshing/operators/swap_edge.h"

#include <algorithm>

#include "meshing/operators/check_cavity.h"
#include "meshing/operators/surface_fit.h"
#include "meshing/operators/swap_common.h"

namespace weft::meshing {
namespace {

/// Best triangulation of the ring polygon by dynamic programming over its chains i..j.
struct RingTriangulation {
  double best[kMaxRing][kMaxRing];
  std::int8_t apex[kMaxRing][kMaxRing];
  float quality[kMaxRing][kMaxRing][2];  ///< of the tets (triangle, a) and (triangle, b) on chain i..j
};

/// Qualities of the tets over ring triangle (i, k, j), i < k < j, with the edge's two ends.
std::pair<double, double> judge_triangle(MetricMean mean, const Corner& a, const Corner& b,
                                         const Corner* ring, int i, int k, int j, double enough) {
  const double qb = judge_quality_above(enough, mean, ring[i], ring[k], ring[j], b);
  if (qb <= enough) return {qb, -1};
  return {qb, judge_quality_above(enough, mean, ring[k], ring[i], ring[j], a)};
}

/// Would a tet over ring triangle (i, k, j) lie flat upon a curved surface?
bool lies_down(const TetMesh& mesh, const Shell& shell, int i, int k, int j) {
  const int on =
      mesh.flags(shell.ring[i]) & mesh.flags(shell.ring[k]) & mesh.flags(shell.ring[j]) & kOnCurved;
  return on & (mesh.flags(shell.a) | mesh.flags(shell.b));
}

/// Fills `r`; false when no triangulation has all tets better than `enough`.
bool triangulate(MetricMean mean, const TetMesh& mesh, const Shell& shell, const Corner& a, const Corner& b,
                 const Corner* ring, int m, double enough, RingTriangulation& r) {
  for (int i = 0; i + 1 < m; ++i) r.best[i][i + 1] = 2;
  for (int width = 2; width < m; ++width)
    for (int i = 0; i + width < m; ++i) {
      const int j = i + width;
      r.best[i][j] = enough;
      r.apex[i][j] = -1;
      for (int k = i + 1; k < j; ++k) {
        const double bound = std::min(r.best[i][k], r.best[k][j]);
        if (bound <= r.best[i][j] || lies_down(mesh, shell, i, k, j)) continue;
        const auto [qb, qa] = judge_triangle(mean, a, b, ring, i, k, j, r.best[i][j]);
        const double q = std::min({bound, qa, qb});
        if (q <= r.best[i][j]) continue;
        r.best[i][j] = q;
        r.apex[i][j] = static_cast<std::int8_t>(k);
        r.quality[i][j][0] = static_cast<float>(qa);
        r.quality[i][j][1] = static_cast<float>(qb);
      }
    }
  return r.apex[0][m - 1] >= 0;
}

/// Writes the tets of the chosen triangulation into the hole that the shell leaves.
class RingBuilder {
 public:
  RingBuilder(Worker& w, const Shell& shell, const RingTriangulation& r)
      : w_(w), mesh_(w.mesh), shell_(shell), r_(r) {
    for (int i = 0; i < shell.size; ++i) {
      const auto& e = shell.tets[i];
      outer_a_[i] = outer_face(mesh_, e.tet, e.b);
      outer_b_[i] = outer_face(mesh_, e.tet, e.a);
    }
    ref_ = mesh_.ref(shell.tets[0].tet);
  }

  /// The faces over one ring chord, on a's and on b's side.
  struct Faces {
    TetFace a, b;
  };

  /// Builds all tets of a closed shell.
  void build_closed() {
    const int m = shell_.size;
    const Faces root = chain(0, m - 1);
    attach(root.a, outer_a_[m - 1]);
    attach(root.b, outer_b_[m - 1]);
    free_unused();
  }

  /// Builds all tets of an open shell; the faces over the ring's closing edge come to lie on `patch`.
  Faces build_open(PatchId patch) {
    const Faces root = chain(0, shell_.size);
    mark_if_short(w_, shell_.ring[0], shell_.ring[shell_.size]);
    attach(root.a, {TetFace(), patch});
    attach(root.b, {TetFace(), patch});
    free_unused();
    return root;
  }

 private:
  void free_unused() {
    for (; used_ < shell_.size; ++used_) w_.free(shell_.tets[used_].tet);
  }

  TetId next_tet() { return used_ < shell_.size ? shell_.tets[used_++].tet : w_.new_tet(); }

  void attach(TetFace f, const OuterFace& o) {
    mesh_.set_neighbour(f.tet(), f.face(), o.neighbour);
    if (o.neighbour.valid()) mesh_.set_neighbour(o.neighbour.tet(), o.neighbour.face(), f);
    mesh_.set_patch(f.tet(), f.face(), o.patch);
  }

  TetId write(const TetVertices& v, float quality) {
    const TetId t = next_tet();
    mesh_.set_vertices(t, v);
    mesh_.set_ref(t, ref_);
    mesh_.set_quality(t, quality);
    for (int f = 0; f < 4; ++f) mesh_.set_patch(t, f, PatchId());
    mesh_.mark(t, kAllTetMarks);
    for (const VertexId x : v) {
      mesh_.set_tet_of(x, t);
      mesh_.touch(x);
    }
    return t;
  }

  /// Triangulates chain i..j and returns the open faces over its chord.
  Faces chain(int i, int j) {
    const int k = r_.apex[i][j];
    const VertexId vi = shell_.ring[i], vk = shell_.ring[k], vj = shell_.ring[j];
    const TetId tb = write({vi, vk, vj, shell_.b}, r_.quality[i][j][1]);
    const TetId ta = write({vk, vi, vj, shell_.a}, r_.quality[i][j][0]);
    mesh_.glue(TetFace(ta, 3), TetFace(tb, 3));
    side(i, k, TetFace(ta, 2), TetFace(tb, 2));  // opposite vj
    side(k, j, TetFace(ta, 1), TetFace(tb, 0));  // opposite vi
    return {TetFace(ta, 0), TetFace(tb, 1)};     // opposite vk
  }

  void side(int i, int j, TetFace fa, TetFace fb) {
    if (j == i + 1) {
      attach(fa, outer_a_[i]);
      attach(fb, outer_b_[i]);
      return;
    }
    mark_if_short(w_, shell_.ring[i], shell_.ring[j]);
    const Faces below = chain(i, j);
    mesh_.glue(fa, below.a);
    mesh_.glue(fb, below.b);
  }

  Worker& w_;
  TetMesh& mesh_;
  const Shell& shell_;
  const RingTriangulation& r_;
  std::array<OuterFace, kMaxRing> outer_a_, outer_b_;
  std::int32_t ref_;
  int used_ = 0;
};

/// Open shell: the boundary edge becomes the one between the ends of the ring.
Verdict judge_boundary(Worker& w, const Shell& shell, PatchId patch) {
  const VertexId c = shell.ring[0], d = shell.ring[shell.size];
  const std::array<VertexId, 3> old_a = {shell.a, shell.b, c}, old_b = {shell.b, shell.a, d};
  if (!w.kernel.surface.patches()[patch.value].planar) {
    const double before = edge_deviation(w.kernel, shell.a, shell.b, patch);
    if (!fits_surface(w.kernel, patch, {c, shell.a, d}, old_a, before) ||
        !fits_surface(w.kernel, patch, {d, shell.b, c}, old_b, before))
      return Verdict::leaves_surface;
  }
  // The cavity changes its outline here: an edge across it may exist already, outside, where the boundary
  // bends.
  for (int i = 0; i + 2 <= shell.size; ++i) {
    if (w.mesh.frozen(shell.ring[i])) return Verdict::frozen;  // its ball is not all here
    if (const Verdict r = gather_ball(w.mesh, w.claims, shell.ring[i], w.other_ball); r != Verdict::accepted)
      return r;
    for (const auto& [t, local] : w.other_ball.tets)
      for (int j = i + 2; j <= shell.size; ++j)
        if (w.mesh.local_index(t, shell.ring[j]) >= 0) return Verdict::breaks_topology;
  }
  return Verdict::accepted;
}

/// The best triangulation of one shell's ring, if all its tets are better than `enough`.
Verdict judge_ring(const Worker& w, const Shell& shell, double enough, RingTriangulation& r) {
  const int m = shell.closed ? shell.size : shell.size + 1;
  if (m > kMaxRing) return Verdict::too_large;
  if (m < 3) return Verdict::not_needed;
  std::array<Corner, kMaxRing> ring;
  for (int i = 0; i < m; ++i) ring[i] = w.corner(shell.ring[i]);
  return triangulate(w.mean(), w.mesh, shell, w.corner(shell.a), w.corner(shell.b), ring.data(), m, enough, r)
             ? Verdict::accepted
             : Verdict::worsens_quality;
}

/// At most so many tets replace those of a shell: two over each triangle of the ring's polygon.
std::size_t tets_over(const Shell& shell) { return 2 * static_cast<std::size_t>(shell.size); }

Verdict swap_inside(Worker& w, const Shell& shell, double enough) {
  RingTriangulation r;
  if (const Verdict v = judge_ring(w, shell, enough, r); v != Verdict::accepted) return v;
  if (!w.secure(tets_over(shell), 0)) return Verdict::too_large;
  RingBuilder(w, shell, r).build_closed();
  return Verdict::accepted;
}

Verdict swap_on_boundary(Worker& w, const Shell& shell, PatchId patch, double enough) {
  RingTriangulation r;
  if (const Verdict v = judge_ring(w, shell, enough, r); v != Verdict::accepted) return v;
  if (const Verdict v = judge_boundary(w, shell, patch); v != Verdict::accepted) return v;
  if (!w.secure(tets_over(shell), 0)) return Verdict::too_large;
  RingBuilder(w, shell, r).build_open(patch);
  return Verdict::accepted;
}

/// The part of a closed shell from ring vertex `from` on, `size` tets, as an open shell.
Shell part_of(const Shell& shell, int from, int size) {
  Shell part;
  part.a = shell.a;
  part.b = shell.b;
  part.size = size;
  for (int i = 0; i < size; ++i) part.tets[i] = shell.tets[(from + i) % shell.size];
  for (int i = 0; i <= size; ++i) part.ring[i] = shell.ring[(from + i) % shell.size];
  return part;
}

/// An edge of an interface inside the mesh: its shell is two open shells, one a material, which are swapped
/// together.
Verdict swap_on_interface(Worker& w, const Shell& shell, PatchId patch, double enough) {
  std::array<int, 2> at;
  int found = 0;
  for (int i = 0; i < shell.size; ++i) {
    if (!w.mesh.patch(shell.tets[i].tet, shell.tets[i].r).valid()) continue;
    if (found == 2) return Verdict::breaks_classification;
    at[found++] = (i + 1) % shell.size;  // the face opposite r ends at the next ring vertex
  }
  if (found != 2) return Verdict::breaks_classification;
  const int size = (at[1] - at[0] + shell.size) % shell.size;
  const std::array<Shell, 2> halves = {part_of(shell, at[0], size), part_of(shell, at[1], shell.size - size)};
  std::array<RingTriangulation, 2> r;
  for (int i = 0; i < 2; ++i) {
    if (const Verdict v = judge_ring(w, halves[i], enough, r[i]); v != Verdict::accepted) return v;
    if (const Verdict v = judge_boundary(w, halves[i], patch); v != Verdict::accepted) return v;
  }
  if (!w.secure(tets_over(halves[0]) + tets_over(halves[1]), 0)) return Verdict::too_large;
  RingBuilder first(w, halves[0], r[0]), second(w, halves[1], r[1]);
  const RingBuilder::Faces one = first.build_open(patch), other = second.build_open(patch);
  w.mesh.glue(one.a, other.a);
  w.mesh.glue(one.b, other.b);
  return Verdict::accepted;
}

}  // namespace

Verdict swap_edge(Worker& w, TetId t, VertexId a, VertexId b) {
  TetMesh& mesh = w.mesh;
  const Shell& shell = w.shell;
  float worst = mesh.quality(t);
  const auto is_ours = [&](TetId u) {
    worst = std::min(worst, mesh.quality(u));
    return !leaves_swap_to(mesh, t, u);
  };
  if (const Verdict r = gather_shell_while(mesh, w.claims, t, a, b, w.shell, is_ours); r != Verdict::accepted)
    return r;
  if (incomplete(mesh, shell)) return Verdict::frozen;
  const EdgeClass on = classify(mesh, shell);
  if (on.kind == VertexKind::ridge) return Verdict::breaks_classification;
  const double enough = enough_for_swap(worst);
  const Verdict r = on.kind == VertexKind::interior ? swap_inside(w, shell, enough)
                    : shell.closed                  ? swap_on_interface(w, shell, on.patch, enough)
                                                    : swap_on_boundary(w, shell, on.patch, enough);
  if (r == Verdict::accepted) check_cavity(w, shell.ring[0]);
  return r;
}

}  // namespace weft::meshing
