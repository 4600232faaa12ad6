// Linear interpolation between meshes by point location.
#include "meshing/fields/interpolate.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "meshing/base/assert.h"
#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/predicates.h"
#include "meshing/metric/background.h"

namespace weft::meshing {
namespace {

/// Exactly: a flat tet that is positive may compute no volume.
bool is_positive(const MeshData& mesh, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return orientation(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) > 0;
}

/// None for a flat tet that computes a negative volume.
double six_volume_of(const MeshData& mesh, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return std::max(0.0, six_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]));
}

void check(const MeshData& from) {
  if (from.tets.empty()) throw InputError("", "", "has no tetrahedra");
  const std::size_t bad = find_first(from.tets.size(), [&](std::size_t t) { return !is_positive(from, t); });
  if (bad < from.tets.size())
    throw InputError("", "tet " + std::to_string(bad + 1), "has no volume or is inverted");
}

void read(const Field& from, const std::array<std::uint32_t, 4>& tet, const Background::Barycentric& at,
          std::size_t to_vertex, Field& to) {
  const auto n = static_cast<std::size_t>(components(from.kind));
  for (std::size_t c = 0; c < n; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      // A weight of zero keeps out what it multiplies, be it infinite.
      if (at[i] > 0) sum += at[i] * from.values[n * tet[i] + c];
    to.values[n * to_vertex + c] = sum;
  }
}

SolutionData empty_like(const SolutionData& fields, std::size_t num_points) {
  SolutionData result{num_points, {}};
  for (const Field& field : fields.fields)
    result.fields.push_back(
        {field.kind, std::vector<double>(num_points * static_cast<std::size_t>(components(field.kind))),
         field.name});
  return result;
}

}  // namespace

Background field_background(const MeshData& from) {
  check(from);
  return {from, {}, build_adjacency(from.tets, from.points.size())};
}

Interpolation interpolate(const MeshData& from, const SolutionData& fields, const MeshData& to) {
  return interpolate(field_background(from), fields, to);
}

Interpolation interpolate(const Background& from, const SolutionData& fields, const MeshData& to) {
  WEFT_ASSERT_LIGHT(fields.num_points == from.mesh().points.size(), "one value a vertex");
  // Vertices in pieces of fixed size, each walking from where its last one was: no result depends on threads.
  constexpr std::size_t kPiece = 256;
  const std::size_t n = to.points.size();
  Interpolation result{empty_like(fields, n), std::vector<std::uint32_t>(n), 0, 0};
  std::vector<double> distances(n);
  tbb::parallel_for(std::size_t{0}, (n + kPiece - 1) / kPiece, [&](std::size_t piece) {
    std::uint32_t hint = Background::kNoHint;
    for (std::size_t v = piece * kPiece; v < std::min(n, (piece + 1) * kPiece); ++v) {
      const Background::Place place = from.locate(to.points[v], hint);
      result.places[v] = hint = place.tet;
      distances[v] = std::sqrt(place.distance2);
      for (std::size_t f = 0; f < fields.fields.size(); ++f)
        read(fields.fields[f], from.mesh().tets[place.tet], place.at, v, result.fields.fields[f]);
    }
  });
  for (std::size_t v = 0; v < n; ++v) {
    result.farthest = std::max(result.farthest, distances[v]);
    result.outside += distances[v] > 0;
  }
  return result;
}

std::vector<double> integrals(const MeshData& mesh, const Field& field) {
  const auto n = static_cast<std::size_t>(components(field.kind));
  std::vector<double> sums(n, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double weight = six_volume_of(mesh, t) / 24;
    for (const std::uint32_t v : mesh.tets[t])
      for (std::size_t c = 0; c < n; ++c) sums[c] += weight * field.values[n * v + c];
  }
  return sums;
}

}  // namespace weft::meshing
