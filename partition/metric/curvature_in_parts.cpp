// The part's own vertices are looked at with the triangles at them, as those of a subdomain are.
#include "partition/metric/curvature_in_parts.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/geometry/surface/face_directions.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/subdomain/surface_cover.h"
#include "partition/surface/boundary_index.h"
#include "partition/surface/boundary_share.h"
#include "partition/surface/surface_parts.h"
#include "partition/surface/surface_pieces.h"

namespace weft::partition {
namespace {

using meshing::CurvedVertex;
using meshing::PatchEdge;
using meshing::Point;

/// All ranks.
SurfaceParts surface_of(Peers& peers, const MeshSlice& slice, double ridge_angle_degrees,
                        const std::shared_ptr<const meshing::Model>& model) {
  const Ranges points(peers, slice.points.size());
  const auto fetch_points = [&](const std::vector<std::uint32_t>& numbers) {
    return fetch<Point>(peers, points, numbers, [&](std::size_t i) { return slice.points[i]; });
  };
  std::vector<std::string> warnings;  // who adapts tells them
  return build_surface_parts(peers, listed_boundary(peers, slice), fetch_points, ridge_angle_degrees, model,
                             warnings);
}

std::vector<CurvedVertex> vertices_of(const PartDomain& domain, const BoundaryIndex& index) {
  std::vector<CurvedVertex> vertices;
  vertices.reserve(domain.numbers().size());
  for (const Point& x : domain.mesh().points) {
    CurvedVertex& vertex = vertices.emplace_back(CurvedVertex{x});
    const std::uint32_t place = index.vertex(domain.numbers()[vertices.size() - 1]);
    if (place == BoundaryIndex::kNone) continue;
    vertex.kind = index.kind(place);
    vertex.hint = index.hint(place);
  }
  return vertices;
}

/// The edges of curved patches at own vertices.
std::vector<PatchEdge> own_edges(const PartDomain& domain, const BoundaryIndex& index,
                                 std::span<const meshing::Patch> patches,
                                 const std::vector<CurvedVertex>& vertices, SurfaceCover& cover) {
  std::vector<PatchEdge> edges;
  const auto at = [&](std::uint32_t v) { return SurfaceCover::Vertex{vertices[v].x, vertices[v].hint}; };
  for (const BoundaryRecords::Face& face : index.faces()) {
    if (patches[face.patch.value].planar) continue;
    std::array<std::uint32_t, 3> places;
    for (std::size_t i = 0; i < 3; ++i)
      places[i] = static_cast<std::uint32_t>(meshing::place_in(domain.numbers(), face.vertices[i]));
    const std::size_t before = edges.size();
    for (const std::uint32_t v : places)
      if (domain.owns(v)) meshing::add_patch_edges(v, face.patch, places, edges);
    if (edges.size() == before) continue;
    for (const std::uint32_t v : places) cover.add(at(v));
    cover.add_face(at(places[0]), at(places[1]), at(places[2]));
  }
  cover.finish();
  return edges;
}

}  // namespace

meshing::LogMetricField curvature_in_parts(Peers& peers, const MeshSlice& slice, const PartDomain& domain,
                                           const meshing::CurvatureOptions& options,
                                           const std::shared_ptr<const meshing::Model>& model) {
  SurfaceParts parts = surface_of(peers, slice, options.ridge_angle_degrees, model);
  const std::shared_ptr<const Geometry> geometry = parts.geometry;
  const BoundaryIndex index(peers, std::exchange(parts.records, {}), domain.numbers());
  const std::vector<CurvedVertex> vertices = vertices_of(domain, index);
  SurfaceCover cover;
  std::vector<PatchEdge> edges = own_edges(domain, index, geometry->surface.patches(), vertices, cover);
  meshing::SurfacePieces pieces;
  pieces.add(pieces_near(peers, parts.cutter.get(), {&cover, 1})[0]);
  parts = {};
  meshing::LogMetricField field = meshing::curvature_metric(
      geometry->surface.part(std::move(pieces)), vertices, std::move(edges), options, domain.largest_size());
  domain.refresh(field);
  return field;
}

bool may_curve(Peers& peers, const MeshSlice& slice, double ridge_angle_degrees) {
  const meshing::MeshData& share = slice.boundary;
  std::vector<std::uint32_t> numbers;
  const auto is_sound = [&](const auto& triangle) { return std::ranges::max(triangle) < slice.num_points; };
  for (const auto& triangle : share.triangles)
    if (is_sound(triangle)) numbers.insert(numbers.end(), triangle.begin(), triangle.end());
  meshing::sort_unique(numbers);
  const Ranges points(peers, slice.points.size());
  const std::vector<Point> at =
      fetch<Point>(peers, points, numbers, [&](std::size_t i) { return slice.points[i]; });
  const auto point = [&](std::uint32_t number) -> const Point& {
    return at[meshing::place_in(numbers, number)];
  };
  meshing::FaceDirections directions;
  for (std::size_t t = 0; t < share.triangles.size(); ++t) {
    const auto& [a, b, c] = share.triangles[t];
    if (!is_sound(share.triangles[t])) continue;
    directions.add(share.triangle_refs[t], point(a), point(b), point(c));
  }
  const auto merged = [](meshing::FaceDirections all, const meshing::FaceDirections& more) {
    all.merge(more);
    return all;
  };
  return reduce(peers, std::vector{directions}, merged)[0].may_curve(ridge_angle_degrees);
}

}  // namespace weft::partition
