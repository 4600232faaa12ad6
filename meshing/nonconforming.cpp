// One pass over the tets; the few edges that are wrong are listed, so that each counts once.
#include "meshing/nonconforming.h"

#include <algorithm>
#include <array>
#include <vector>

#include "meshing/quality.h"
#include "meshing/tet_tables.h"

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
      : mesh_(mesh), flags_(flags), left_out_(one_in - 1) {}

  void look_at(TetId t, Found& found) const {
    const TetVertices v = mesh_.vertices(t);
    std::array<bool, 4> flagged;
    for (int i = 0; i < 4; ++i) flagged[i] = mesh_.flags(v[i]) & flags_;
    const bool any = flagged[0] | flagged[1] | flagged[2] | flagged[3];
    Nonconforming& part = any ? found.parts.flagged : found.parts.plain;
    ++part.tets;
    part.poor_tets += mesh_.quality(t) < kPoorQuality;
    if (!(in_sample(v[0]) | in_sample(v[1]) | in_sample(v[2]) | in_sample(v[3]))) return;
    for (const auto& e : kTetEdges)
      if (in_sample(std::min(v[e[0]], v[e[1]])))
        look_at(v[e[0]], v[e[1]], flagged[e[0]] || flagged[e[1]], found);
  }

 private:
  bool in_sample(VertexId v) const { return (v.value & left_out_) == 0; }

  /// Nearly all edges are unit by the metrics of both ends: then no mean need be taken, nor a root.
  void look_at(VertexId a, VertexId b, bool flagged, Found& found) const {
    const Vec v = mesh_.point(b) - mesh_.point(a);
    const double by_a = squared_length(mesh_.metric(a), v), by_b = squared_length(mesh_.metric(b), v);
    if (std::min(by_a, by_b) >= kShortest && std::max(by_a, by_b) <= kLongest) return;
    const double length = length_between(mesh_, a, b);
    if (length * length >= kShortest && length * length <= kLongest) return;
    found.edges.push_back({std::min(a.value, b.value), std::max(a.value, b.value), length > 1, flagged});
  }

  const TetMesh& mesh_;
  const std::uint8_t flags_;
  const std::uint32_t left_out_;  ///< vertices with one of these bits in their id
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

NonconformingParts count_nonconforming(const TetMesh& mesh, std::uint8_t flags, std::uint32_t one_in) {
  const Count count(mesh, flags, one_in);
  Found found;
  for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
    if (mesh.alive(TetId(t))) count.look_at(TetId(t), found);
  count_edges(one_in, found);
  return found.parts;
}

}  // namespace weft::meshing
