// Rings by marking vertices and looking at all triangles.
#include "partition/distribute/local_surface.h"

#include <algorithm>
#include <array>

namespace weft::partition {
namespace {

using meshing::MeshData;

constexpr std::uint32_t kAbsent = 0xFFFFFFFFu;
constexpr std::uint8_t kFar = 3;

/// By triangle of the boundary; kFar beyond the second.
std::vector<std::uint8_t> rings_around(const MeshData& all, const std::vector<std::uint32_t>& own) {
  std::vector<std::uint8_t> rings(all.triangles.size(), kFar);
  for (const std::uint32_t t : own) rings[t] = 0;
  std::vector<bool> touched(all.points.size());
  for (std::uint8_t ring = 1; ring < kFar; ++ring) {
    for (std::size_t t = 0; t < rings.size(); ++t)
      if (rings[t] + 1 == ring)
        for (const std::uint32_t v : all.triangles[t]) touched[v] = true;
    for (std::size_t t = 0; t < rings.size(); ++t)
      if (rings[t] == kFar &&
          std::ranges::any_of(all.triangles[t], [&](std::uint32_t v) { return touched[v]; }))
        rings[t] = ring;
  }
  return rings;
}

class Extractor {
 public:
  Extractor(const WholeBoundary& boundary, const std::vector<std::uint32_t>& own)
      : all_(boundary.data), numbers_(boundary.numbers), rings_(rings_around(all_, own)) {}

  LocalSurface extract() {
    take_vertices();
    take_triangles();
    take_edges();
    take_listed(all_.corners, vertex_, s_.mesh.corners);
    take_listed(all_.required_points, vertex_, s_.mesh.required_points);
    return std::move(s_);
  }

 private:
  void take_vertices();
  void take_triangles();
  void take_edges();
  static void take_listed(const std::vector<std::uint32_t>& listed, const std::vector<std::uint32_t>& places,
                          std::vector<std::uint32_t>& taken) {
    for (const std::uint32_t i : listed)
      if (places[i] != kAbsent) taken.push_back(places[i]);
  }

  const MeshData& all_;
  const std::vector<std::uint32_t>& numbers_;
  std::vector<std::uint8_t> rings_;
  std::vector<std::uint32_t> vertex_;  // place here by vertex of the boundary
  LocalSurface s_;
};

void Extractor::take_vertices() {
  vertex_.assign(all_.points.size(), kAbsent);
  for (std::size_t t = 0; t < rings_.size(); ++t)
    if (rings_[t] < kFar)
      for (const std::uint32_t v : all_.triangles[t]) vertex_[v] = 0;
  for (std::uint32_t v = 0; v < vertex_.size(); ++v) {
    if (vertex_[v] == kAbsent) continue;
    vertex_[v] = static_cast<std::uint32_t>(s_.vertices.size());
    s_.vertices.push_back(numbers_[v]);
    s_.mesh.points.push_back(all_.points[v]);
  }
}

void Extractor::take_triangles() {
  std::vector<std::uint32_t> place(rings_.size(), kAbsent);
  for (std::uint32_t t = 0; t < rings_.size(); ++t) {
    if (rings_[t] == kFar) continue;
    place[t] = static_cast<std::uint32_t>(s_.triangles.size());
    s_.triangles.push_back(t);
    s_.rings.push_back(rings_[t]);
    const auto& [a, b, c] = all_.triangles[t];
    s_.mesh.triangles.push_back({vertex_[a], vertex_[b], vertex_[c]});
    s_.mesh.triangle_refs.push_back(all_.triangle_refs[t]);
  }
  take_listed(all_.required_triangles, place, s_.mesh.required_triangles);
}

void Extractor::take_edges() {
  std::vector<std::uint32_t> place(all_.edges.size(), kAbsent);
  for (std::size_t e = 0; e < all_.edges.size(); ++e) {
    const std::uint32_t a = vertex_[all_.edges[e][0]], b = vertex_[all_.edges[e][1]];
    if (a == kAbsent || b == kAbsent) continue;
    place[e] = static_cast<std::uint32_t>(s_.mesh.edges.size());
    s_.mesh.edges.push_back({a, b});
    s_.mesh.edge_refs.push_back(all_.edge_refs[e]);
  }
  take_listed(all_.required_edges, place, s_.mesh.required_edges);
}

}  // namespace

LocalSurface local_surface(const WholeBoundary& boundary, const std::vector<std::uint32_t>& own) {
  return Extractor(boundary, own).extract();
}

}  // namespace weft::partition
