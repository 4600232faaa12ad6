// Metrics that the boundary asks for: sizes from its curvature, and first layers at walls.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "weft/data.h"

namespace weft::meshing {

/// The size where nothing is asked for: the diagonal of the mesh's bounding box, 1 for a mesh without any.
double largest_size(const MeshData& mesh);

/// On curved patches of the boundary (and of material interfaces) sizes h = 2 pi R / per_turn, and
/// h = sqrt(8 R sagitta), along the principal directions of curvature with their radii R; across the surface
/// the smaller of the two. largest_size elsewhere: gradation carries the demand into the volume. A vertex
/// between patches takes the intersection of their demands. Curvature is fitted by least squares to the
/// neighbours on the patch and the normal of the reference geometry (surface.h): exact on spheres, and on
/// cylinders to the second order of the edge length. Triangles must be all of the boundary, as surface.h
/// says. Multithreaded; does not depend on the number of threads. Throws InputError for an index out of
/// range.
LogMetricField curvature_metric(const MeshData& mesh, const CurvatureOptions& options);

/// At distance d from the nearest wall the size across it is h(d) = height + (growth - 1) d, the continuous
/// form of layers that grow geometrically, and along it the larger of `tangential` and h(d); none is larger
/// than largest_size. The direction across is that to the nearest point of the walls, on a wall its normal;
/// where walls meet at an angle the demands of all of them are intersected. O((n + w) log w) for w wall
/// triangles; multithreaded; does not depend on the number of threads. Throws InputError naming a reference
/// that no triangle has, and for a height that is not positive or a growth below 1.
LogMetricField wall_metric(const MeshData& mesh, const WallOptions& options);

}  // namespace weft::meshing
