// The metric that the curvature of the boundary asks for.
#pragma once

#include <memory>
#include <optional>

#include "meshing/geometry/model.h"
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
/// face are not believed, nor below a thousandth of the size of a face with a tip. `largest`: largest_size of
/// the whole mesh, where this is a part of it.
LogMetricField curvature_metric(const MeshData& mesh, const CurvatureOptions& options,
                                std::shared_ptr<const Model> model = nullptr,
                                std::optional<double> largest = std::nullopt);

}  // namespace weft::meshing
