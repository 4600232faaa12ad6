// One pass over the tets; the few edges that are wrong are listed, so that each counts once.
#include "meshing/kernel/nonconforming.h"

#include <algorithm>
#include <array>
#include <vector>

#include "meshing/kernel/quality.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {
namespace {

constexpr double kShortest = 0.5, kLongest = 2;  // squared

struct WrongEdge {
  std::uint32_t a, b;  // a < b
  bool too_long, flagged;
  friend auto operator<=>(const WrongEdge&, const WrongEdge&) = default;
};

struct Found {
  NonconformingParts parts;
  std::vector<WrongEdge> edges;
};

class Count {
 public:
  Count(const TetMesh& mesh, std::uint8_t flags, std::uint32_t one_in)
      : mesh_(mesh), what_(mesh.vertex_slots()) {
    for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
      what_[i] = (mesh.flags(VertexId(i)) & flags ? kFlagged : 0) | (i % one_in == 0 ? kInSample : 0);
  }

  /// All but the edges without a branch: nearly all tets have nothing to be looked at.
  Found run() const {
    Found found;
    std::array<std::uint64_t, 2> tets{}, poor_tets{};
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i) {
      const TetId t(i);
      const TetVertices v = mesh_.vertices(t);
      const std::uint8_t any = what(v[0]) | what(v[1]) | what(v[2]) | what(v[3]);
      const bool alive = mesh_.alive(t);
      tets[any & kFlagged] += alive;
      poor_tets[any & kFlagged] += alive & (mesh_.quality(t) < kPoorQuality);
      if ((any & kInSample) != 0 && alive) look_at_edges(v, found.edges);
    }
    found.parts.plain.tets = tets[0], found.parts.plain.poor_tets = poor_tets[0];
    found.parts.flagged.tets = tets[kFlagged], found.parts.flagged.poor_tets = poor_tets[kFlagged];
    return found;
  }

 private:
  static constexpr std::uint8_t kFlagged = 1, kInSample = 2;
  std::uint8_t what(VertexId v) const { return what_[v.value]; }

  void look_at_edges(const TetVertices& v, std::vector<WrongEdge>& edges) const {
    for (const auto& e : kTetEdges) {
      const VertexId a = std::min(v[e[0]], v[e[1]]), b = std::max(v[e[0]], v[e[1]]);
      if ((what(a) & kInSample) != 0) look_at(a, b, edges);
    }
  }

  /// Nearly all edges are unit by the metrics of both ends: then no mean need be taken, nor a root.
  void look_at(VertexId a, VertexId b, std::vector<WrongEdge>& edges) const {
    const Vec v = mesh_.point(b) - mesh_.point(a);
    const double by_a = squared_length(mesh_.metric(a), v), by_b = squared_length(mesh_.metric(b), v);
    if (std::min(by_a, by_b) >= kShortest && std::max(by_a, by_b) <= kLongest) return;
    const double length = length_between(mesh_, a, b);
    if (length * length >= kShortest && length * length <= kLongest) return;
    edges.push_back({a.value, b.value, length > 1, ((what(a) | what(b)) & kFlagged) != 0});
  }

  const TetMesh& mesh_;
  std::vector<std::uint8_t> what_;  ///< by vertex slot
};

void count_edges(std::uint32_t one_in, Found& found) {
  std::vector<WrongEdge>& edges = found.edges;
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const WrongEdge& e : edges) {
    Nonconforming& part = e.flagged ? found.parts.flagged : found.parts.plain;
    (e.too_long ? part.long_edges : part.short_edges) += one_in;
  }
}

}  // namespace

Nonconforming& Nonconforming::operator+=(const Nonconforming& other) {
  tets += other.tets;
  poor_tets += other.poor_tets;
  long_edges += other.long_edges;
  short_edges += other.short_edges;
  return *this;
}

Nonconforming& Nonconforming::operator-=(const Nonconforming& other) {
  tets -= other.tets;
  poor_tets -= other.poor_tets;
  long_edges -= other.long_edges;
  short_edges -= other.short_edges;
  return *this;
}

NonconformingParts count_nonconforming(const TetMesh& mesh, std::uint8_t flags, std::uint32_t one_in) {
  Found found = Count(mesh, flags, one_in).run();
  count_edges(one_in, found);
  return found.parts;
}

}  // namespace weft::meshing
