// Closest points from the parameters of a vertex nearby.
#include "meshing/geometry/model/face_deviations.h"

#include <algorithm>
#include <limits>

namespace weft::meshing {

FaceDeviations::FaceDeviations(const MeshData& mesh, const Model& model)
    : mesh_(mesh), model_(model), records_(mesh.association.faces) {
  std::ranges::stable_sort(records_, {}, &OnFace::vertex);
}

std::vector<Association::OnFace>::const_iterator FaceDeviations::first_of(std::uint32_t vertex) const {
  return std::ranges::lower_bound(records_, vertex, {}, &OnFace::vertex);
}

bool FaceDeviations::lies_on(std::uint32_t vertex, std::int32_t face) const {
  for (auto r = first_of(vertex); r != records_.end() && r->vertex == vertex; ++r)
    if (r->id == face) return true;
  return false;
}

double FaceDeviations::at(const Triangle& triangle) const {
  const auto& [a, b, c] = triangle;
  const Point centroid = (1.0 / 3) * (mesh_.points[a] + mesh_.points[b] + mesh_.points[c]);
  double least = std::numeric_limits<double>::quiet_NaN();
  for (auto r = first_of(a); r != records_.end() && r->vertex == a; ++r) {
    const auto face = static_cast<std::uint32_t>(r->id - 1);
    if (r->id < 1 || face >= model_.num_faces() || !lies_on(b, r->id) || !lies_on(c, r->id)) continue;
    const double distance = model_.closest_on_face(face, centroid, {r->u, r->v}).distance;
    if (!(distance >= least)) least = distance;
  }
  return least;
}

}  // namespace weft::meshing
