// Counting by references.
#include "meshing/io/files/part_writer.h"

#include <algorithm>

namespace weft::meshing {

std::uint64_t sum_of(const RefCounts& counts) {
  std::uint64_t sum = 0;
  for (const auto& [ref, count] : counts) sum += count;
  return sum;
}

RefCounts count_refs(std::span<const std::int32_t> refs) {
  RefCounts counts;
  for (std::size_t i = 0; i < refs.size();) {  // equal ones mostly follow one another
    std::size_t end = i + 1;
    while (end < refs.size() && refs[end] == refs[i]) ++end;
    counts[refs[i]] += end - i;
    i = end;
  }
  return counts;
}

WholeMesh describe(const MeshView& contents) {
  const MeshData& mesh = contents.mesh;
  WholeMesh whole;
  whole.points = mesh.points.size();
  whole.tets = count_refs(mesh.tet_refs);
  whole.triangles = count_refs(mesh.triangle_refs);
  whole.edges = count_refs(mesh.edge_refs);
  for (const std::uint32_t v : mesh.corners) whole.corners.push_back({v, mesh.points[v], mesh.point_refs[v]});
  whole.point_refs = has_refs(mesh.point_refs);
  if (!mesh.points.empty()) whole.low = whole.high = mesh.points[0];
  for (const Point& p : mesh.points)
    for (int c = 0; c < 3; ++c) {
      whole.low[c] = std::min(whole.low[c], p[c]);
      whole.high[c] = std::max(whole.high[c], p[c]);
    }
  whole.names = contents.names;
  whole.fields.num_points = mesh.points.size();
  for (const Field& field : contents.fields.fields)
    whole.fields.fields.push_back({field.kind, {}, field.name});
  return whole;
}

MeshRows<std::uint32_t> all_rows(const MeshView& contents) {
  const MeshData& mesh = contents.mesh;
  const auto from_first = [](const std::vector<std::int32_t>& refs) {
    RefCounts counts = count_refs(refs);
    for (auto& [ref, first] : counts) first = 0;
    return counts;
  };
  return {0,
          mesh.points,
          mesh.point_refs,
          {mesh.tets, mesh.tet_refs, 0, from_first(mesh.tet_refs)},
          {mesh.triangles, mesh.triangle_refs, 0, from_first(mesh.triangle_refs)},
          {mesh.edges, mesh.edge_refs, 0, from_first(mesh.edge_refs)},
          contents.fields};
}

}  // namespace weft::meshing
