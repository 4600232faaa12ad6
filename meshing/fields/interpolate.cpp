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

bool is_outside(const MeshData& mesh, const TetLocator::Place& place) {
  constexpr double kRounding = 1e-12;  // of the square of a tet's size
  const auto& tet = mesh.tets[place.tet];
  return place.distance2 > kRounding * norm2(mesh.points[tet[1]] - mesh.points[tet[0]]);
}

std::size_t width(const Field& field) { return static_cast<std::size_t>(components(field.kind)); }

}  // namespace

void read_at(const TetLocator::Place& place, const std::array<std::uint32_t, 4>& tet, const ValueTable& table,
             double* values) {
  for (std::size_t c = 0; c < table.columns; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      // A weight of zero keeps out what it multiplies, be it infinite.
      if (place.at[i] > 0) sum += place.at[i] * table.values[tet[i] * table.columns + c];
    values[c] = sum;
  }
}

void check_volumes(const MeshData& mesh) {
  const std::size_t bad = find_first(mesh.tets.size(), [&](std::size_t t) { return !is_positive(mesh, t); });
  if (bad < mesh.tets.size())
    throw InputError("", "tet " + std::to_string(bad + 1), "has no volume or is inverted");
}

TetLocator locator_in(const MeshData& from) {
  if (from.tets.empty()) throw InputError("", "", "has no tetrahedra");
  check_volumes(from);
  return {from, build_adjacency(from.tets, from.points.size())};
}

ValueTable packed(const SolutionData& fields) {
  ValueTable table;
  for (const Field& field : fields.fields) table.columns += width(field);
  table.values.resize(fields.num_points * table.columns);
  std::size_t first = 0;
  for (const Field& field : fields.fields) {
    const std::size_t n = width(field);
    for (std::size_t v = 0; v < fields.num_points; ++v)
      std::copy_n(field.values.data() + v * n, n, table.values.data() + v * table.columns + first);
    first += n;
  }
  return table;
}

void unpack(const ValueTable& table, SolutionData& fields) {
  const std::size_t count = table.columns > 0 ? table.values.size() / table.columns : 0;
  fields.num_points = count;
  std::size_t first = 0;
  for (Field& field : fields.fields) {
    const std::size_t n = width(field);
    field.values.resize(count * n);
    for (std::size_t v = 0; v < count; ++v)
      std::copy_n(table.values.data() + v * table.columns + first, n, field.values.data() + v * n);
    first += n;
  }
}

Interpolation interpolate(const MeshData& from, const SolutionData& fields, const MeshData& to) {
  const ValuesAt read = interpolate(locator_in(from), packed(fields), to.points);
  Interpolation result;
  for (const Field& field : fields.fields) result.fields.fields.push_back({field.kind, {}, field.name});
  unpack(read.table, result.fields);
  result.fields.num_points = to.points.size();
  for (std::size_t v = 0; v < to.points.size(); ++v) {
    if (!read.outside[v]) continue;
    result.farthest = std::max(result.farthest, read.distances[v]);
    ++result.outside;
  }
  return result;
}

ValuesAt interpolate(const TetLocator& from, const ValueTable& table, std::span<const Point> points) {
  WEFT_ASSERT_LIGHT(table.values.size() == table.columns * from.mesh().points.size(), "one value a vertex");
  // Vertices in pieces of fixed size, each walking from where its last one was: no result depends on threads.
  constexpr std::size_t kPiece = 256;
  const std::size_t n = points.size();
  ValuesAt result{{table.columns, std::vector<double>(n * table.columns)},
                  std::vector<std::uint32_t>(n),
                  std::vector<double>(n),
                  std::vector<std::uint8_t>(n)};
  tbb::parallel_for(std::size_t{0}, (n + kPiece - 1) / kPiece, [&](std::size_t piece) {
    std::uint32_t hint = TetLocator::kNoHint;
    for (std::size_t v = piece * kPiece; v < std::min(n, (piece + 1) * kPiece); ++v) {
      const TetLocator::Place place = from.locate(points[v], hint);
      result.places[v] = hint = place.tet;
      result.distances[v] = std::sqrt(place.distance2);
      result.outside[v] = is_outside(from.mesh(), place);
      read_at(place, from.mesh().tets[place.tet], table, result.table.values.data() + v * table.columns);
    }
  });
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
