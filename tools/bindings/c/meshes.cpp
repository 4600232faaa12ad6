// Meshes: arrays in and out, files, checks, simple bodies.
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "tools/bindings/c/calls.h"

namespace weft::c {
namespace {

std::string place(const char* array, std::int64_t row) {
  return std::string(array) + "[" + std::to_string(row) + "]: ";
}

/// An index or reference, narrowed to weft's own type.
template <class To>
To narrow(std::int64_t value, std::int64_t least, std::int64_t most, const char* array, std::int64_t row) {
  if (value < least || value > most)
    throw InputError("", "",
                     place(array, row) + std::to_string(value) + " is not from " + std::to_string(least) +
                         " to " + std::to_string(most));
  return static_cast<To>(value);
}

std::int64_t size_of(const auto& array) { return static_cast<std::int64_t>(array.size()); }

/// Rows of N indices below `limit`.
template <std::size_t N, class Value>
void read_rows(std::vector<std::array<std::uint32_t, N>>& to, std::int64_t count, const Value* values,
               std::int64_t limit, const char* array) {
  std::vector<std::array<std::uint32_t, N>> rows(static_cast<std::size_t>(count));
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (std::size_t i = 0; i < N; ++i)
      rows[r][i] =
          narrow<std::uint32_t>(values[N * r + i], 0, limit - 1, array, static_cast<std::int64_t>(r));
  to = std::move(rows);
}

void read_indices(std::vector<std::uint32_t>& to, std::int64_t count, const std::int64_t* values,
                  std::int64_t limit, const char* array) {
  std::vector<std::uint32_t> indices(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < indices.size(); ++i)
    indices[i] = narrow<std::uint32_t>(values[i], 0, limit - 1, array, static_cast<std::int64_t>(i));
  to = std::move(indices);
}

void read_refs(std::vector<std::int32_t>& to, std::int64_t count, const std::int64_t* values,
               std::int64_t entities, const char* array) {
  require(count == entities, std::string(array) + ": " + std::to_string(count) + " references for " +
                                 std::to_string(entities) + " entities");
  using Limits = std::numeric_limits<std::int32_t>;
  std::vector<std::int32_t> refs(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < refs.size(); ++i)
    refs[i] =
        narrow<std::int32_t>(values[i], Limits::min(), Limits::max(), array, static_cast<std::int64_t>(i));
  to = std::move(refs);
}

template <class Index>
weft_status create(std::int64_t num_points, const double* points, std::int64_t num_tets, const Index* tets,
                   weft_mesh** mesh) {
  return guarded([&] {
    require_place(mesh, "mesh");
    require_array(points, num_points, 3, "points");
    require_array(tets, num_tets, 4, "tets");
    require(num_points < std::numeric_limits<std::uint32_t>::max(),
            "points: " + std::to_string(num_points) + " are more than a mesh can have");
    auto made = std::make_shared<Mesh>();
    made->points.resize(static_cast<std::size_t>(num_points));
    for (std::size_t p = 0; p < made->points.size(); ++p) {
      made->points[p] = {points[3 * p], points[3 * p + 1], points[3 * p + 2]};
      for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(made->points[p][axis]))
          throw InputError("", "", place("points", static_cast<std::int64_t>(p)) + "is not finite");
    }
    read_rows<4>(made->tets, num_tets, tets, num_points, "tets");
    made->point_refs.resize(made->points.size());
    made->tet_refs.resize(made->tets.size());
    give_mesh(mesh, std::move(made));
  });
}

std::int64_t width_of(weft_array which) {
  switch (which) {
    case WEFT_TETS:
      return 4;
    case WEFT_TRIANGLES:
      return 3;
    case WEFT_EDGES:
      return 2;
    case WEFT_TET_REFS:
    case WEFT_TRIANGLE_REFS:
    case WEFT_EDGE_REFS:
    case WEFT_POINT_REFS:
    case WEFT_CORNERS:
    case WEFT_REQUIRED_POINTS:
    case WEFT_RIDGES:
    case WEFT_REQUIRED_EDGES:
    case WEFT_REQUIRED_TRIANGLES:
      return 1;
  }
  throw Misuse("which: " + std::to_string(static_cast<int>(which)) + " is none of weft_array");
}

/// Calls use(array) with the mesh's array of that name.
template <class AnyMesh, class Use>
void with_array(AnyMesh& mesh, weft_array which, const Use& use) {
  switch (which) {
    case WEFT_TETS:
      return use(mesh.tets);
    case WEFT_TET_REFS:
      return use(mesh.tet_refs);
    case WEFT_TRIANGLES:
      return use(mesh.triangles);
    case WEFT_TRIANGLE_REFS:
      return use(mesh.triangle_refs);
    case WEFT_EDGES:
      return use(mesh.edges);
    case WEFT_EDGE_REFS:
      return use(mesh.edge_refs);
    case WEFT_POINT_REFS:
      return use(mesh.point_refs);
    case WEFT_CORNERS:
      return use(mesh.corners);
    case WEFT_REQUIRED_POINTS:
      return use(mesh.required_points);
    case WEFT_RIDGES:
      return use(mesh.ridges);
    case WEFT_REQUIRED_EDGES:
      return use(mesh.required_edges);
    case WEFT_REQUIRED_TRIANGLES:
      return use(mesh.required_triangles);
  }
}

/// References of new entities are 0 until they are set.
void set_array(Mesh& mesh, weft_array which, std::int64_t count, const std::int64_t* values) {
  const std::int64_t points = size_of(mesh.points), edges = size_of(mesh.edges),
                     triangles = size_of(mesh.triangles);
  switch (which) {
    case WEFT_TETS:
      read_rows<4>(mesh.tets, count, values, points, "tets");
      return mesh.tet_refs.assign(mesh.tets.size(), 0);
    case WEFT_TRIANGLES:
      read_rows<3>(mesh.triangles, count, values, points, "triangles");
      return mesh.triangle_refs.assign(mesh.triangles.size(), 0);
    case WEFT_EDGES:
      read_rows<2>(mesh.edges, count, values, points, "edges");
      return mesh.edge_refs.assign(mesh.edges.size(), 0);
    case WEFT_TET_REFS:
      return read_refs(mesh.tet_refs, count, values, size_of(mesh.tets), "tet_refs");
    case WEFT_TRIANGLE_REFS:
      return read_refs(mesh.triangle_refs, count, values, triangles, "triangle_refs");
    case WEFT_EDGE_REFS:
      return read_refs(mesh.edge_refs, count, values, edges, "edge_refs");
    case WEFT_POINT_REFS:
      return read_refs(mesh.point_refs, count, values, points, "point_refs");
    case WEFT_CORNERS:
      return read_indices(mesh.corners, count, values, points, "corners");
    case WEFT_REQUIRED_POINTS:
      return read_indices(mesh.required_points, count, values, points, "required_points");
    case WEFT_RIDGES:
      return read_indices(mesh.ridges, count, values, edges, "ridges");
    case WEFT_REQUIRED_EDGES:
      return read_indices(mesh.required_edges, count, values, edges, "required_edges");
    case WEFT_REQUIRED_TRIANGLES:
      return read_indices(mesh.required_triangles, count, values, triangles, "required_triangles");
  }
}

void copy_out(const std::vector<std::uint32_t>& from, std::int64_t* to) {
  for (const std::uint32_t value : from) *to++ = value;
}
void copy_out(const std::vector<std::int32_t>& from, std::int64_t* to) {
  for (const std::int32_t value : from) *to++ = value;
}
template <std::size_t N>
void copy_out(const std::vector<std::array<std::uint32_t, N>>& from, std::int64_t* to) {
  for (const auto& row : from)
    for (const std::uint32_t value : row) *to++ = value;
}

std::string problems_of(const CheckReport& report) {
  std::string text = std::to_string(report.num_problems) + " problems";
  for (const std::string& problem : report.problems) text += "; " + problem;
  return text;
}

BoxOptions cells_of(std::int64_t nx, std::int64_t ny, std::int64_t nz) {
  constexpr std::int64_t kMost = 100000;
  BoxOptions options;
  const std::array<std::int64_t, 3> cells = {nx, ny, nz};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require(cells[axis] >= 1 && cells[axis] <= kMost,
            "cells: " + std::to_string(cells[axis]) + " is not from 1 to " + std::to_string(kMost));
    options.cells[axis] = static_cast<std::uint32_t>(cells[axis]);
  }
  require(nx * ny <= (std::int64_t{1} << 28) / nz, "cells: more than a mesh can have");
  return options;
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_mesh_create(int64_t num_points, const double* points, int64_t num_tets, const int64_t* tets,
                             weft_mesh** mesh) {
  return create(num_points, points, num_tets, tets, mesh);
}

weft_status weft_mesh_create32(int64_t num_points, const double* points, int64_t num_tets,
                               const int32_t* tets, weft_mesh** mesh) {
  return create(num_points, points, num_tets, tets, mesh);
}

weft_status weft_mesh_set(weft_mesh* mesh, weft_array which, int64_t count, const int64_t* values) {
  return guarded([&] {
    const auto object = object_of<MeshObject>(mesh, "mesh");
    require_array(values, count, width_of(which), "values");
    set_array(object->own(), which, count, values);
  });
}

weft_status weft_mesh_num_points(const weft_mesh* mesh, int64_t* count) {
  return guarded([&] {
    require_place(count, "count");
    *count = size_of(mesh_of(mesh)->points);
  });
}

weft_status weft_mesh_count(const weft_mesh* mesh, weft_array which, int64_t* count) {
  return guarded([&] {
    require_place(count, "count");
    width_of(which);
    const auto known = mesh_of(mesh);
    with_array(*known, which, [&](const auto& array) { *count = size_of(array); });
  });
}

weft_status weft_mesh_get(const weft_mesh* mesh, weft_array which, int64_t capacity, int64_t* values) {
  return guarded([&] {
    const auto known = mesh_of(mesh);
    const std::int64_t width = width_of(which);
    require_array(values, capacity, 1, "values");
    with_array(*known, which, [&](const auto& array) {
      require(width * size_of(array) <= capacity, "capacity: " + std::to_string(capacity) + " numbers, but " +
                                                      std::to_string(width * size_of(array)) + " are needed");
      copy_out(array, values);
    });
  });
}

weft_status weft_mesh_points(const weft_mesh* mesh, const double** points) {
  return guarded([&] {
    require_place(points, "points");
    const auto known = mesh_of(mesh);
    *points = known->points.empty() ? nullptr : &known->points.front().x;
  });
}

weft_status weft_mesh_tets(const weft_mesh* mesh, const uint32_t** tets) {
  return guarded([&] {
    require_place(tets, "tets");
    const auto known = mesh_of(mesh);
    *tets = known->tets.empty() ? nullptr : known->tets.front().data();
  });
}

weft_status weft_mesh_read(const char* path, weft_mesh** mesh) {
  return guarded([&] {
    const std::string file = require_text(path, "path");
    require_place(mesh, "mesh");
    give_mesh(mesh, std::make_shared<weft::Mesh>(weft::read_mesh(file)));
  });
}

weft_status weft_mesh_write(const weft_mesh* mesh, const char* path) {
  return guarded([&] { weft::write_mesh(require_text(path, "path"), *mesh_of(mesh)); });
}

weft_status weft_mesh_verify(const weft_mesh* mesh, int64_t* num_problems, double* volume) {
  return guarded([&] {
    require_place(num_problems, "num_problems");
    const weft::CheckReport report = weft::verify(*mesh_of(mesh));
    if (!report.ok()) set_last_error(problems_of(report));
    *num_problems = static_cast<std::int64_t>(report.num_problems);
    if (volume) *volume = report.volume;
  });
}

weft_status weft_mesh_box(int64_t nx, int64_t ny, int64_t nz, weft_mesh** mesh) {
  const std::array<int64_t, 3> cells = {nx, ny, nz};
  constexpr std::array<double, 3> kMin = {0, 0, 0}, kMax = {1, 1, 1};
  return weft_mesh_box_between(cells.data(), kMin.data(), kMax.data(), mesh);
}

weft_status weft_mesh_box_between(const int64_t cells[3], const double min[3], const double max[3],
                                  weft_mesh** mesh) {
  return guarded([&] {
    require_place(mesh, "mesh");
    require(cells, "cells: is NULL, not three numbers");
    weft::BoxOptions options = cells_of(cells[0], cells[1], cells[2]);
    options.min = point_of(min, "min");
    options.max = point_of(max, "max");
    for (int axis = 0; axis < 3; ++axis)
      require(options.min[axis] < options.max[axis], "max: must be above min in every direction");
    give_mesh(mesh, std::make_shared<weft::Mesh>(weft::box(options)));
  });
}

}  // extern "C"
