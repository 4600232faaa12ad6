// The metric that the curvature of the boundary asks for.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "meshing/geometry/model/model.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

/// On curved patches of the boundary (and of material interfaces) sizes h = 2 pi R / per_turn, and
/// h = sqrt(8 R sagitta), along the principal directions of curvature with their radii R; across the surface
/// the smaller of the two. largest_size elsewhere: gradation carries the demand into the volume. A vertex
/// between patches takes the intersection of their demands. Curvature is fitted by least squares to the
/// neighbours on the patch and the normal of the reference geometry (surface.h): exact on spheres, and on
/// cylinders to the second order of the edge length. Triangles must be all of the boundary, as surface.h
/// says. Multithreaded; does not depend on the number of threads. Throws InputError for an index out of
/// range.
/// With a model the curvature is the model's, where the boundary lies on it; radii below 100 tolerances of a
/// face are not believed, nor below a thousandth of the size of a face with a tip.
LogMetricField curvature_metric(const MeshData& mesh, const CurvatureOptions& options,
                                std::shared_ptr<const Model> model = nullptr);

/// A vertex as the surface knows it: of no patch where the kind is interior.
struct CurvedVertex {
  Point x;
  VertexKind kind = VertexKind::interior;
  std::uint32_t hint = kNoName;
};
/// An edge of a curved patch, seen from its vertex.
struct PatchEdge {
  std::uint32_t vertex, patch, other;
  friend auto operator<=>(const PatchEdge&, const PatchEdge&) = default;
};
/// The edges of a triangle of a curved patch at one of its vertices.
void add_patch_edges(std::uint32_t vertex, PatchId patch, const std::array<std::uint32_t, 3>& triangle,
                     std::vector<PatchEdge>& edges);
/// The same of a part of a mesh, whose `surface` has what is near: `edges` are all of a vertex, in any order
/// and also repeated, or none: then the size is `largest`, largest_size of the whole mesh. The bits are those
/// of the whole mesh, where vertices have the same order there.
LogMetricField curvature_metric(const Surface& surface, const std::vector<CurvedVertex>& vertices,
                                std::vector<PatchEdge> edges, const CurvatureOptions& options,
                                double largest);

}  // namespace weft::meshing
