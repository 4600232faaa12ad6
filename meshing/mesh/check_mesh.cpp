// The full check of a mesh that is whole in memory.
#include "meshing/mesh/check_mesh.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "meshing/mesh/check_steps.h"
#include "meshing/mesh/problems.h"

namespace weft::meshing {
namespace {

using namespace checks;

/// The sign of every tet's orientation; reports those that are not positive.
std::vector<std::int8_t> orientations(const MeshData& mesh, Problems& problems) {
  std::vector<std::int8_t> signs(mesh.tets.size());
  find_in_chunks(mesh.tets.size(), problems, [&](std::size_t begin, std::size_t end, Problems& found) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& [a, b, c, d] = mesh.tets[t];
      const auto& p = mesh.points;
      signs[t] = check_orientation(t, {p[a], p[b], p[c], p[d]}, found);
    }
  });
  return signs;
}

void sum_sizes(const MeshData& mesh, CheckReport& report) {
  const auto& p = mesh.points;
  put_volumes(sum_by_ref(mesh.tet_refs,
                         [&](std::size_t t) {
                           const auto& [a, b, c, d] = mesh.tets[t];
                           return volume_of({p[a], p[b], p[c], p[d]});
                         }),
              report);
  report.area_by_ref = values_of(sum_by_ref(mesh.triangle_refs, [&](std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return area_of({p[a], p[b], p[c]});
  }));
}

/// Of where vertices lie on a CAD model.
template <class Record>
void check_records(const char* entity, const std::vector<Record>& records, std::size_t num_points,
                   Problems& problems) {
  for (std::size_t i = 0; i < records.size(); ++i)
    if (records[i].vertex >= num_points)
      problems.add("record ", i + 1, " of a vertex on ", entity, ": vertex ",
                   std::uint64_t{records[i].vertex} + 1, " is out of range (", num_points, " entities)");
}

std::uint64_t count_unreferenced(const MeshData& mesh) {
  std::vector<std::uint8_t> used(mesh.points.size(), 0);
  for (const Tet& tet : mesh.tets)
    for (const std::uint32_t v : tet) used[v] = 1;
  return static_cast<std::uint64_t>(std::count(used.begin(), used.end(), 0));
}

}  // namespace

void check_arrays(const MeshData& mesh, Problems& problems, CollapsedTriangles collapsed) {
  check_references("vertex", mesh.point_refs.size(), mesh.points.size(), problems);
  check_references("tet", mesh.tet_refs.size(), mesh.tets.size(), problems);
  check_references("triangle", mesh.triangle_refs.size(), mesh.triangles.size(), problems);
  check_references("edge", mesh.edge_refs.size(), mesh.edges.size(), problems);
  check_coordinates(mesh.points, problems);
  check_vertices("tet", mesh.tets, mesh.points.size(), problems);
  check_vertices("triangle", mesh.triangles, mesh.points.size(), problems, 0,
                 collapsed == CollapsedTriangles::allowed);
  check_vertices("edge", mesh.edges, mesh.points.size(), problems);
  check_list("corner", mesh.corners, mesh.points.size(), problems);
  check_list("required vertex", mesh.required_points, mesh.points.size(), problems);
  check_list("ridge", mesh.ridges, mesh.edges.size(), problems);
  check_list("required edge", mesh.required_edges, mesh.edges.size(), problems);
  check_list("required triangle", mesh.required_triangles, mesh.triangles.size(), problems);
  check_records("a node of a model", mesh.association.nodes, mesh.points.size(), problems);
  check_records("an edge of a model", mesh.association.edges, mesh.points.size(), problems);
  check_records("a face of a model", mesh.association.faces, mesh.points.size(), problems);
  if (mesh.tets.size() >= std::size_t{1} << 30) problems.add("more than 1073741823 tets");
}

CheckReport check_mesh(const MeshData& mesh, int max_problems) {
  CheckReport report;
  Problems problems(static_cast<std::size_t>(std::max(max_problems, 0)));
  check_arrays(mesh, problems);
  if (problems.count() == 0) {
    const std::vector<std::int8_t> signs = orientations(mesh, problems);
    FaceCheck faces(mesh, signs);
    faces.run(problems);
    report_triangles(faces.triangles(), faces.matched(), problems);
    report.num_components = faces.num_components();
    EdgeCheck edges(mesh);
    edges.mark(mesh.tets);
    edges.mark(mesh.triangles);
    EdgeCheck::report(edges.found(), problems);
    sum_sizes(mesh, report);
    report.unreferenced_points = count_unreferenced(mesh);
    report.touching_edges = faces.count_touching_edges();
    report.touching_vertices = faces.count_balls() - (mesh.points.size() - report.unreferenced_points);
  }
  report.num_problems = problems.count();
  report.problems = problems.take();
  return report;
}

}  // namespace weft::meshing
