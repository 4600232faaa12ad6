// Facets tell what volume a tet is in: each of their sides keeps the reference of the tets that were there.
#include "meshing/initial/grid/grid_of_mesh.h"

#include <algorithm>

#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/renumber_vertices.h"

namespace weft::meshing {
namespace {

/// Whether a tet's face, seen with the tet on its positive side, turns as the triangle does.
bool turns_alike(const Face3& face, const Face3& triangle) {
  const auto first = std::find(face.begin(), face.end(), triangle[0]) - face.begin();
  return face[static_cast<std::size_t>(first + 1) % 3] == triangle[1];
}

template <class Use>
void for_facet_faces(const TetGrid& grid, const Use& use) {
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    for (int f = 0; f < 4; ++f)
      if (const std::uint32_t facet = grid.tets[t].facet[f]; facet != kNothing)
        use(t, facet, grid.face(t, f));
  }
}

void fill(TetGrid& grid, const MeshData& mesh) {
  for (const Point& p : mesh.points) grid.add_point(p);
  const Adjacency adjacency = build_adjacency(mesh.tets, mesh.points.size());
  grid.tets.resize(mesh.tets.size());
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    grid.tets[t].v = mesh.tets[t];
    grid.tets[t].n = adjacency.neighbours[t];
    for (const std::uint32_t v : mesh.tets[t]) grid.vertex_tet[v] = t;
  }
  const std::vector<std::uint32_t> codes = match_triangles(mesh.triangles, mesh.tets, mesh.points.size());
  for (std::uint32_t i = 0; i < codes.size(); ++i)
    if (codes[i] != kNoNeighbour) grid.set_facet(codes[i] >> 2, static_cast<int>(codes[i] & 3), i);
}

}  // namespace

GridOfMesh::GridOfMesh(MeshData mesh) : mesh_(std::move(mesh)), refs_(2 * mesh_.triangles.size()) {
  fill(grid, mesh_);
  for_facet_faces(grid, [&](std::uint32_t t, std::uint32_t facet, const Face3& face) {
    ref_beside(facet, face) = mesh_.tet_refs[t];
  });
}

std::int32_t& GridOfMesh::ref_beside(std::uint32_t facet, const Face3& face) {
  return refs_[2 * facet + turns_alike(face, mesh_.triangles[facet])];
}

std::vector<std::uint32_t> GridOfMesh::points_of_tets() const {
  std::vector<char> held(grid.points.size());
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t)
    if (grid.alive(t))
      for (const std::uint32_t v : grid.tets[t].v) held[v] = true;
  std::vector<std::uint32_t> points;
  points.reserve(held.size());
  for (std::uint32_t v = 0; v < held.size(); ++v)
    if (held[v]) points.push_back(v);
  return points;
}

/// Returns where each point that tets hold is now.
std::vector<std::uint32_t> GridOfMesh::close_points() {
  const std::vector<std::uint32_t> points = points_of_tets();
  std::vector<std::uint32_t> place(grid.points.size(), kNothing);
  mesh_.points.resize(points.size());
  mesh_.point_refs.resize(grid.points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    mesh_.points[i] = grid.points[points[i]];
    mesh_.point_refs[i] = mesh_.point_refs[points[i]];
    place[points[i]] = i;
  }
  mesh_.point_refs.resize(points.size());
  return place;
}

MeshData GridOfMesh::take() {
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> region = flood_regions(grid, count);
  std::vector<std::int32_t> ref(count);
  for_facet_faces(grid, [&](std::uint32_t t, std::uint32_t facet, const Face3& face) {
    ref[region[t]] = ref_beside(facet, face);
  });
  mesh_.tets.clear();
  mesh_.tet_refs.clear();
  for (std::uint32_t t = 0; t < grid.tets.size(); ++t) {
    if (!grid.alive(t)) continue;
    mesh_.tets.push_back(grid.tets[t].v);
    mesh_.tet_refs.push_back(ref[region[t]]);
  }
  const std::vector<std::uint32_t> place = close_points();
  renumber_vertices(mesh_.tets, place);
  renumber_vertices(mesh_.triangles, place);
  renumber_vertices(mesh_.edges, place);
  for (auto* list : {&mesh_.corners, &mesh_.required_points})
    for (std::uint32_t& v : *list) v = place[v];
  return std::move(mesh_);
}

}  // namespace weft::meshing
