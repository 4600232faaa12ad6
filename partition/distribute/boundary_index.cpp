// The classification of meshing::import_mesh, looked up by vertices.
#include "partition/distribute/boundary_index.h"

#include <algorithm>

#include "meshing/kernel/tet_mesh.h"

namespace weft::partition {

using meshing::CurveId;
using meshing::PatchId;
using FeatureEdge = meshing::Surface::FeatureEdge;

BoundaryIndex::BoundaryIndex(const WholeBoundary& boundary, const Geometry& geometry)
    : boundary_(boundary), geometry_(geometry), flags_(boundary.numbers.size(), 0) {
  const auto& triangles = boundary.data.triangles;
  faces_.reserve(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    faces_.emplace_back(triangles[i], geometry.surface.triangle_patch(i));
    std::sort(faces_.back().first.begin(), faces_.back().first.end());
  }
  std::sort(faces_.begin(), faces_.end());
  edges_.assign(geometry.surface.feature_edges().begin(), geometry.surface.feature_edges().end());
  std::sort(edges_.begin(), edges_.end(),
            [](const FeatureEdge& a, const FeatureEdge& b) { return a.vertices < b.vertices; });
  set_flags();
}

void BoundaryIndex::set_flags() {
  const meshing::MeshData& d = boundary_.data;
  const auto add = [&](std::uint32_t v, int flags) {
    flags_[v] = static_cast<std::uint8_t>(flags_[v] | flags);
  };
  for (std::uint32_t v = 0; v < flags_.size(); ++v)
    if (kind(v) == meshing::VertexKind::corner) add(v, meshing::kFixed);
  for (std::uint32_t i = 0; i < d.triangles.size(); ++i)
    if (!geometry_.surface.patches()[geometry_.surface.triangle_patch(i).value].planar)
      for (const std::uint32_t v : d.triangles[i]) add(v, meshing::kOnCurved);
  for (const std::uint32_t t : d.required_triangles)
    for (const std::uint32_t v : d.triangles[t]) add(v, meshing::kFixed);
  for (const std::uint32_t e : d.required_edges)
    for (const std::uint32_t v : d.edges[e]) add(v, meshing::kFixed);
  for (const std::uint32_t v : d.required_points) add(v, meshing::kFixed | meshing::kListedRequired);
  for (const std::uint32_t v : d.corners) add(v, meshing::kFixed | meshing::kListedCorner);
}

std::uint32_t BoundaryIndex::vertex(std::uint32_t number) const {
  const auto& numbers = boundary_.numbers;
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), number);
  return found != numbers.end() && *found == number ? static_cast<std::uint32_t>(found - numbers.begin())
                                                    : kNone;
}

PatchId BoundaryIndex::patch(Face face) const {
  std::sort(face.begin(), face.end());
  const auto found = std::lower_bound(faces_.begin(), faces_.end(), face,
                                      [](const auto& entry, const Face& f) { return entry.first < f; });
  return found != faces_.end() && found->first == face ? found->second : PatchId{};
}

CurveId BoundaryIndex::curve(std::uint32_t a, std::uint32_t b) const {
  const std::array<std::uint32_t, 2> edge{std::min(a, b), std::max(a, b)};
  const auto found = std::lower_bound(edges_.begin(), edges_.end(), edge,
                                      [](const FeatureEdge& e, const auto& v) { return e.vertices < v; });
  return found != edges_.end() && found->vertices == edge ? found->curve : CurveId{};
}

}  // namespace weft::partition
