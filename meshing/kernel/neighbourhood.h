// Ball of a vertex and shell of an edge, gathered under claims without allocation.
#pragma once

#include <array>
#include <cstdint>

#include "meshing/base/filled_array.h"
#include "meshing/base/small_set.h"
#include "meshing/kernel/speculation.h"
#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// The tets around a vertex, with the vertex's local index in each, and the vertices of its link.
struct Ball {
  static constexpr std::size_t kMaxSize = 1024;
  struct Entry {
    TetId tet;
    int local;
  };
  struct LinkVertex {
    VertexId vertex;
    std::uint32_t first;  ///< of the tets that have it, in their order
  };
  VertexId centre;
  FilledArray<Entry> tets;
  FilledArray<LinkVertex> link;
  SmallSet seen, seen_vertices;  // scratch of gather_ball
};

/// The tets around edge (a, b). Tet s is (a, b, ring[s], ring[s + 1]) up to an even permutation; a closed
/// shell has ring.front() == ring.back(). An open one starts and ends at a face without neighbour.
struct Shell {
  static constexpr int kMaxSize = 256;
  struct Entry {
    TetId tet;
    int a, b, r, s;
  };  ///< local indices, (a, b, r, s) an even permutation
  VertexId a, b;
  bool closed = false;
  int size = 0;
  std::array<Entry, kMaxSize> tets;
  std::array<VertexId, kMaxSize + 1> ring;
};

/// The two local indices besides a pair.
inline constexpr std::array<std::array<std::array<std::int8_t, 2>, 4>, 4> kOtherTwo = [] {
  std::array<std::array<std::array<std::int8_t, 2>, 4>, 4> table{};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0, n = 0; i != j && k < 4; ++k)
        if (k != i && k != j) table[i][j][n++] = static_cast<std::int8_t>(k);
  return table;
}();

/// Adds the tet across face `f` of `t` to a ball, unless it has been seen. Until the ball is complete its
/// `local` is the face across which it was found.
inline void add_neighbour(const TetMesh& mesh, TetId t, int f, Ball& ball) {
  const TetFace n = mesh.neighbour(t, f);
  if (!n.valid()) return;
  mesh.prefetch(n.tet());
  ball.tets.push_if(ball.seen.insert(n.tet().value), {n.tet(), n.face()});
}

/// Gathers the ball of `centre` and claims all its vertices. Anything but accepted: something could not be
/// claimed.
inline Verdict gather_ball(const TetMesh& mesh, Claims& claims, VertexId centre, Ball& ball) {
  if (const Verdict r = claims.claim(centre); r != Verdict::accepted) return r;
  if (!mesh.alive(centre)) return Verdict::not_needed;
  ball.centre = centre;
  ball.tets.clear();
  ball.link.clear();
  ball.seen.clear();
  ball.seen_vertices.clear();
  const auto add_to_link = [&](VertexId v, std::size_t first) {
    mesh.prefetch(v);
    ball.link.push_if(ball.seen_vertices.insert(v.value), {v, static_cast<std::uint32_t>(first)});
  };
  const TetId start = mesh.tet_of(centre);
  if (const Verdict r = claims.claim_tet(start); r != Verdict::accepted) return r;
  ball.seen.insert(start.value);
  const int local_in_start = mesh.local_index(start, centre);
  ball.tets.make_room(4);
  ball.tets.push_if(true, {start, local_in_start});
  ball.link.make_room(3);
  for (int i = 0; i < 4; ++i) {
    if (i == local_in_start) continue;
    add_to_link(mesh.vertex(start, i), 0);
    add_neighbour(mesh, start, i, ball);
  }
  for (std::size_t i = 1; i < ball.tets.size(); ++i) {
    const TetId t = ball.tets[i].tet;
    const int back = ball.tets[i].local;
    // Three of its vertices are held already: only the one across the face is new.
    const VertexId across = mesh.vertex(t, back);
    if (const Verdict r = claims.claim(across); r != Verdict::accepted) return r;
    const int local = ball.tets[i].local = mesh.local_index(t, centre);
    ball.link.make_room(1);
    add_to_link(across, i);
    ball.tets.make_room(2);
    for (const int f : kOtherTwo[local][back]) add_neighbour(mesh, t, f, ball);
    if (ball.tets.size() > Ball::kMaxSize) return Verdict::too_large;
  }
  return Verdict::accepted;
}

/// The shell entry of tet `t`, which contains a and b.
inline Shell::Entry shell_entry(const TetMesh& mesh, TetId t, VertexId a, VertexId b) {
  const int i = mesh.local_index(t, a), j = mesh.local_index(t, b);
  const auto& e = kTetEdges[kEdgeOf[i][j]];
  return i < j ? Shell::Entry{t, i, j, e[2], e[3]} : Shell::Entry{t, i, j, e[3], e[2]};
}

/// Gathers the shell of edge (a, b) of tet `t` and claims all its vertices, as long as keep(tet) says so of
/// its tets; else not_needed. `t` must be claimed.
template <class Keep>
Verdict gather_shell_while(const TetMesh& mesh, Claims& claims, TetId t, VertexId a, VertexId b, Shell& shell,
                           const Keep& keep) {
  shell.a = a;
  shell.b = b;
  Shell::Entry first = shell_entry(mesh, t, a, b);
  for (int turn = 0; turn < 2; ++turn) {
    shell.size = 0;
    shell.ring[0] = mesh.vertex(first.tet, first.r);
    Shell::Entry e = first;
    for (;;) {
      if (shell.size == Shell::kMaxSize) return Verdict::too_large;
      shell.tets[shell.size++] = e;
      const VertexId s = mesh.vertex(e.tet, e.s);
      shell.ring[shell.size] = s;
      if (const Verdict r = claims.claim(s); r != Verdict::accepted) return r;
      const TetFace n = mesh.neighbour(e.tet, e.r);
      if (!n.valid()) break;
      if (n.tet() == first.tet) {
        shell.closed = true;
        return Verdict::accepted;
      }
      if (!keep(n.tet())) return Verdict::not_needed;
      e = shell_entry(mesh, n.tet(), a, b);
    }
    shell.closed = false;
    if (turn == 1) break;
    // Open: find the other end, and walk once more from there.
    for (int steps = 0;; ++steps) {
      if (steps == Shell::kMaxSize) return Verdict::too_large;
      if (const Verdict r = claims.claim(mesh.vertex(first.tet, first.r)); r != Verdict::accepted) return r;
      const TetFace n = mesh.neighbour(first.tet, first.s);
      if (!n.valid()) break;
      if (!keep(n.tet())) return Verdict::not_needed;
      first = shell_entry(mesh, n.tet(), a, b);
    }
  }
  return Verdict::accepted;
}
inline Verdict gather_shell(const TetMesh& mesh, Claims& claims, TetId t, VertexId a, VertexId b,
                            Shell& shell) {
  return gather_shell_while(mesh, claims, t, a, b, shell, [](TetId) { return true; });
}

}  // namespace weft::meshing
