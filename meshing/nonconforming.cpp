// One pass over the tets; the few edges that are wrong are listed, so that each counts once.
#include "meshing/nonconforming.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

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
  Count(const TetMesh& mesh, std::uint8_t flags) : mesh_(mesh), flags_(flags) {}

  void look_at(TetId t, Found& found) const {
    const TetVertices v = mesh_.vertices(t);
    std::array<bool, 4> flagged;
    for (int i = 0; i < 4; ++i) flagged[i] = mesh_.flags(v[i]) & flags_;
    const bool any = flagged[0] || flagged[1] || flagged[2] || flagged[3];
    Nonconforming& part = any ? found.parts.flagged : found.parts.plain;
    ++part.tets;
    part.poor_tets += mesh_.quality(t) < kPoorQuality;
    for (const auto& e : kTetEdges) look_at(v[e[0]], v[e[1]], flagged[e[0]] || flagged[e[1]], found);
  }

 private:
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
};

void count_edges(Found& found) {
  std::vector<WrongEdge>& edges = found.edges;
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const WrongEdge& e : edges) {
    Nonconforming& part = e.flagged ? found.parts.flagged : found.parts.plain;
    ++(e.too_long ? part.long_edges : part.short_edges);
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

NonconformingParts count_nonconforming(const TetMesh& mesh, std::uint8_t flags) {
  const Count count(mesh, flags);
  Found found = tbb::parallel_reduce(
      tbb::blocked_range<std::uint32_t>(0, mesh.tet_slots(), 4096), Found{},
      [&](const tbb::blocked_range<std::uint32_t>& r, Found part) {
        for (std::uint32_t t = r.begin(); t < r.end(); ++t)
          if (mesh.alive(TetId(t))) count.look_at(TetId(t), part);
        return part;
      },
      [](Found a, const Found& b) {
        a.parts.plain += b.parts.plain;
        a.parts.flagged += b.parts.flagged;
        a.edges.insert(a.edges.end(), b.edges.begin(), b.edges.end());
        return a;
      });
  count_edges(found);
  return found.parts;
}

}  // namespace weft::meshing
