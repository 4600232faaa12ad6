// Meshes and metrics as objects of Python.
#include <pybind11/stl.h>

#include <limits>

#include "tools/bindings/python/src/arrays.h"
#include "tools/bindings/python/src/parts.h"

namespace weft::python {
namespace {

using MeshPointer = std::shared_ptr<Mesh>;

py::ssize_t length(const auto& array) { return static_cast<py::ssize_t>(array.size()); }

/// Indices as int32, the type of most programs, as long as they fit.
py::array index_view(const std::uint32_t* values, const std::vector<py::ssize_t>& shape, const Mesh& mesh,
                     const py::object& owner) {
  if (mesh.points.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    return view(values, shape, owner);
  return view(reinterpret_cast<const std::int32_t*>(values), shape, owner);
}

template <std::size_t N>
void add_rows(py::class_<Mesh, MeshPointer>& type, const char* name, const char* text,
              std::vector<std::array<std::uint32_t, N>> Mesh::*member) {
  type.def_property_readonly(
      name,
      [member](const py::object& self) {
        const Mesh& mesh = self.cast<const Mesh&>();
        const auto& rows = mesh.*member;
        const std::uint32_t* first = rows.empty() ? nullptr : rows.front().data();
        return index_view(first, {length(rows), static_cast<py::ssize_t>(N)}, mesh, self);
      },
      text);
}

void add_indices(py::class_<Mesh, MeshPointer>& type, const char* name, const char* text,
                 std::vector<std::uint32_t> Mesh::*member) {
  type.def_property_readonly(
      name,
      [member](const py::object& self) {
        const Mesh& mesh = self.cast<const Mesh&>();
        return index_view((mesh.*member).data(), {length(mesh.*member)}, mesh, self);
      },
      text);
}

void add_refs(py::class_<Mesh, MeshPointer>& type, const char* name, const char* text,
              std::vector<std::int32_t> Mesh::*member) {
  type.def_property_readonly(
      name,
      [member](const py::object& self) {
        const Mesh& mesh = self.cast<const Mesh&>();
        return view((mesh.*member).data(), {length(mesh.*member)}, self);
      },
      text);
}

MeshPointer make_mesh(const py::object& points, const py::object& tets, const py::object& triangles,
                      const py::object& edges, const py::object& tet_refs, const py::object& triangle_refs,
                      const py::object& edge_refs, const py::object& point_refs, const py::object& corners,
                      const py::object& ridges, const py::object& required_points,
                      const py::object& required_edges, const py::object& required_triangles) {
  auto mesh = std::make_shared<Mesh>();
  mesh->points = points_of(points, "points");
  const std::size_t count = mesh->points.size();
  if (count >= std::numeric_limits<std::uint32_t>::max())
    throw InputError("", "points", std::to_string(count) + " are more than a mesh can have");
  mesh->point_refs = refs_of(point_refs, count, "point_refs");
  mesh->tets = rows_of<4>(tets, count, "tets");
  mesh->tet_refs = refs_of(tet_refs, mesh->tets.size(), "tet_refs");
  mesh->triangles = rows_of<3>(triangles, count, "triangles");
  mesh->triangle_refs = refs_of(triangle_refs, mesh->triangles.size(), "triangle_refs");
  mesh->edges = rows_of<2>(edges, count, "edges");
  mesh->edge_refs = refs_of(edge_refs, mesh->edges.size(), "edge_refs");
  mesh->corners = indices_of(corners, count, "corners");
  mesh->required_points = indices_of(required_points, count, "required_points");
  mesh->ridges = indices_of(ridges, mesh->edges.size(), "ridges");
  mesh->required_edges = indices_of(required_edges, mesh->edges.size(), "required_edges");
  mesh->required_triangles = indices_of(required_triangles, mesh->triangles.size(), "required_triangles");
  return mesh;
}

std::string described(const Mesh& mesh) {
  return "<weft.Mesh: " + std::to_string(mesh.points.size()) + " points, " +
         std::to_string(mesh.tets.size()) + " tets, " + std::to_string(mesh.triangles.size()) +
         " triangles, " + std::to_string(mesh.edges.size()) + " edges>";
}

void add_mesh(py::module_& module) {
  py::class_<Mesh, MeshPointer> type(module, "Mesh", R"(A tetrahedral mesh, which does not change.

points (n, 3): coordinates. tets (m, 4), triangles (k, 3), edges (l, 2): indices of points, from 0.
*_refs: the reference (label) of each entity, 0 where none is given. corners, required_points (points), ridges,
required_edges (edges) and required_triangles (triangles): indices of what adaptation keeps.
Arrays that it gives out are views of its memory, not to be written to.)");
  const auto none = py::none();
  type.def(py::init(&make_mesh), py::arg("points"), py::arg("tets") = none, py::arg("triangles") = none,
           py::kw_only(), py::arg("edges") = none, py::arg("tet_refs") = none,
           py::arg("triangle_refs") = none, py::arg("edge_refs") = none, py::arg("point_refs") = none,
           py::arg("corners") = none, py::arg("ridges") = none, py::arg("required_points") = none,
           py::arg("required_edges") = none, py::arg("required_triangles") = none);
  type.def_property_readonly(
      "points",
      [](const py::object& self) {
        static_assert(sizeof(Point) == 3 * sizeof(double));
        const Mesh& mesh = self.cast<const Mesh&>();
        return view(mesh.points.empty() ? nullptr : &mesh.points.front().x, {length(mesh.points), 3}, self);
      },
      "(n, 3) float64: coordinates, in the unit of the caller's.");
  add_rows(type, "tets", "(m, 4) int32: indices of points.", &Mesh::tets);
  add_rows(type, "triangles", "(k, 3) int32: of the boundary and between materials.", &Mesh::triangles);
  add_rows(type, "edges", "(l, 2) int32: of ridges and the like.", &Mesh::edges);
  add_refs(type, "point_refs", "(n,) int32.", &Mesh::point_refs);
  add_refs(type, "tet_refs", "(m,) int32: materials.", &Mesh::tet_refs);
  add_refs(type, "triangle_refs", "(k,) int32: patches of the boundary.", &Mesh::triangle_refs);
  add_refs(type, "edge_refs", "(l,) int32.", &Mesh::edge_refs);
  add_indices(type, "corners", "Indices of points.", &Mesh::corners);
  add_indices(type, "required_points", "Indices of points.", &Mesh::required_points);
  add_indices(type, "ridges", "Indices of edges.", &Mesh::ridges);
  add_indices(type, "required_edges", "Indices of edges.", &Mesh::required_edges);
  add_indices(type, "required_triangles", "Indices of triangles.", &Mesh::required_triangles);
  type.def("__repr__", &described);
}

std::optional<std::string> order_of(const py::object& order) {
  if (order.is_none()) return {};
  try {
    return order.cast<std::string>();
  } catch (const py::cast_error&) {
    throw UsageError("order: is no text");
  }
}

void add_metric(py::module_& module) {
  py::class_<Metric, std::shared_ptr<Metric>>(module, "Metric", R"(A metric at every vertex of a mesh.

Of values (n,): sizes, the same in all directions; (n, 3, 3): symmetric positive definite tensors, in which edges
of the wanted size have length 1; (n, 6): the same, with order= 'sol' (11 12 22 13 23 33), 'rows' (11 12 13 22 23
33, as in Mmg's interface) or 'voigt' (11 22 33 23 13 12). Sizes are in the unit of the points.)")
      .def(py::init([](const py::object& values, const py::object& order) {
             return std::make_shared<Metric>(metric_of(values, order_of(order)));
           }),
           py::arg("values"), py::kw_only(), py::arg("order") = py::none())
      .def("__len__", &Metric::size)
      .def("__repr__",
           [](const Metric& metric) {
             return "<weft.Metric at " + std::to_string(metric.size()) + " vertices>";
           })
      .def(
          "tensors",
          [](const Metric& metric, const py::object& order) { return tensors_of(metric, order_of(order)); },
          py::arg("order") = py::none(), "The tensors: (n, 3, 3), or (n, 6) in the order named.");
}

}  // namespace

void add_objects(py::module_& module) {
  add_mesh(module);
  add_metric(module);
}

}  // namespace weft::python
