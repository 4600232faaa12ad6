// Ball of a vertex and shell of an edge, gathered under claims without allocation.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "meshing/base/small_set.h"
#include "meshing/kernel/speculation.h"
#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// The tets around a vertex, with the vertex's local index in each.
struct Ball {
  static constexpr std::size_t kMaxSize = 1024;
  struct Entry {
    TetId tet;
    int local;
  };
  VertexId centre;
  std::vector<Entry> tets;
  SmallSet seen;
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

/// Gathers the ball of `centre` and claims all its vertices. Anything but accepted: something could not be
/// claimed.
inline Verdict gather_ball(const TetMesh& mesh, Claims& claims, VertexId centre, Ball& ball) {
  if (const Verdict r = claims.claim(centre); r != Verdict::accepted) return r;
  if (!mesh.alive(centre)) return Verdict::not_needed;
  ball.centre = centre;
  ball.tets.clear();
  ball.seen.clear();
  const TetId start = mesh.tet_of(centre);
  ball.seen.insert(start.value);
  ball.tets.push_back({start, mesh.local_index(start, centre)});
  if (const Verdict r = claims.claim_tet(start); r != Verdict::accepted) return r;
  for (std::size_t i = 0; i < ball.tets.size(); ++i) {
    const auto [t, local] = ball.tets[i];
    for (int f = 0; f < 4; ++f) {
      const TetFace n = f == local ? TetFace() : mesh.neighbour(t, f);
      if (!n.valid() || !ball.seen.insert(n.tet().value)) continue;
      // Three of its vertices are held already: only the one across the face is new.
      if (const Verdict r = claims.claim(mesh.vertex(n.tet(), n.face())); r != Verdict::accepted) return r;
      ball.tets.push_back({n.tet(), mesh.local_index(n.tet(), centre)});
    }
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

/// Gathers the shell of edge `edge` of tet `t` and claims all its vertices. `t` must be claimed.
inline Verdict gather_shell(const TetMesh& mesh, Claims& claims, TetId t, VertexId a, VertexId b,
                            Shell& shell) {
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
      first = shell_entry(mesh, n.tet(), a, b);
    }
  }
  return Verdict::accepted;
}

}  // namespace weft::meshing
