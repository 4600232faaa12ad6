// Morton order of vertices and the tets that follow it.
#include "meshing/kernel/renumber.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/morton.h"

namespace weft::meshing {
namespace {

Box bounding_box(const TetMesh& mesh) {
  Box b;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i))) b.include(mesh.point(VertexId(i)));
  return b;
}

std::vector<VertexId> curve_order(const TetMesh& mesh, std::uint32_t& count) {
  const Box box = bounding_box(mesh);
  struct Key {
    std::uint64_t code;
    std::uint32_t vertex;
  };
  std::vector<Key> keys;
  keys.reserve(mesh.vertex_slots());
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i))) keys.push_back({0, i});
  Vec scale;
  for (int k = 0; k < 3; ++k) scale[k] = box.hi[k] > box.lo[k] ? 2097151.0 / (box.hi[k] - box.lo[k]) : 0;
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t i) {
    const Vec d = mesh.point(VertexId(keys[i].vertex)) - box.lo;
    for (int k = 0; k < 3; ++k) keys[i].code |= spread_bits(static_cast<std::uint64_t>(d[k] * scale[k])) << k;
  });
  tbb::parallel_sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return a.code != b.code ? a.code < b.code : a.vertex < b.vertex;
  });
  count = static_cast<std::uint32_t>(keys.size());
  std::vector<VertexId> new_vertex(mesh.vertex_slots());
  for (std::uint32_t i = 0; i < count; ++i) new_vertex[keys[i].vertex] = VertexId(i);
  return new_vertex;
}

/// Counting sort of the live tets by their smallest new vertex.
std::vector<TetId> tet_order(const TetMesh& mesh, const std::vector<VertexId>& new_vertex,
                             std::uint32_t num_vertices, std::uint32_t& count) {
  std::vector<std::uint32_t> begin(num_vertices + 1, 0);
  std::vector<std::uint32_t> first(mesh.tet_slots());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    if (!mesh.alive(TetId(i))) continue;
    const TetVertices v = mesh.vertices(TetId(i));
    first[i] = std::min({new_vertex[v[0].value], new_vertex[v[1].value], new_vertex[v[2].value],
                         new_vertex[v[3].value]})
                   .value;
    ++begin[first[i] + 1];
  }
  for (std::uint32_t v = 0; v < num_vertices; ++v) begin[v + 1] += begin[v];
  count = begin[num_vertices];
  std::vector<TetId> new_tet(mesh.tet_slots());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    if (mesh.alive(TetId(i))) new_tet[i] = TetId(begin[first[i]]++);
  return new_tet;
}

}  // namespace

void renumber_along_curve(TetMesh& mesh) {
  std::uint32_t num_vertices = 0, num_tets = 0;
  const std::vector<VertexId> new_vertex = curve_order(mesh, num_vertices);
  const std::vector<TetId> new_tet = tet_order(mesh, new_vertex, num_vertices, num_tets);
  mesh.renumber(new_vertex, num_vertices, new_tet, num_tets);
}

}  // namespace weft::meshing
