// Picks what is flagged and renumbers it.
#include "partition/output/own_entities.h"

#include <algorithm>
#include <cstddef>

namespace weft::partition {
namespace {

using Flags = std::vector<std::uint8_t>;

template <std::size_t N>
std::array<std::uint64_t, N> renumbered(const std::array<std::uint32_t, N>& entity,
                                        const std::vector<std::uint64_t>& numbers) {
  std::array<std::uint64_t, N> result;
  for (std::size_t i = 0; i < N; ++i) result[i] = numbers[entity[i]];
  return result;
}

template <std::size_t N>
void pick(const std::vector<std::array<std::uint32_t, N>>& entities, const std::vector<std::int32_t>& refs,
          const Flags& own, const std::vector<std::uint64_t>& numbers,
          std::vector<std::array<std::uint64_t, N>>& picked, std::vector<std::int32_t>& picked_refs) {
  for (std::size_t e = 0; e < entities.size(); ++e) {
    if (!own[e]) continue;
    picked.push_back(renumbered(entities[e], numbers));
    picked_refs.push_back(refs[e]);
  }
}

template <class T>
std::vector<T> pick_values(const std::vector<T>& values, const Flags& own) {
  std::vector<T> picked;
  picked.reserve(static_cast<std::size_t>(std::ranges::count(own, 1)));
  for (std::size_t i = 0; i < values.size(); ++i)
    if (own[i]) picked.push_back(values[i]);
  return picked;
}

/// The points of a list whose entries have their own flags.
std::vector<std::uint64_t> pick_points(const std::vector<std::uint32_t>& list, const Flags& own,
                                       const std::vector<std::uint64_t>& numbers) {
  std::vector<std::uint64_t> picked;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (own[i]) picked.push_back(numbers[list[i]]);
  }
  return picked;
}

/// The marked ones among a piece's own entities, which are numbered from `first`.
std::vector<std::uint64_t> pick_marks(const std::vector<std::uint32_t>& marked, const Flags& own,
                                      std::uint64_t first) {
  std::vector<std::uint64_t> numbers(own.size());
  for (std::size_t e = 0; e < own.size(); ++e) {
    numbers[e] = first;
    first += own[e];
  }
  std::vector<std::uint64_t> picked;
  for (const std::uint32_t entity : marked) {
    if (own[entity]) picked.push_back(numbers[entity]);
  }
  return picked;
}

template <class Record, class Reals>
std::vector<meshing::gmf::ModelRow> pick_records(const std::vector<Record>& records, const Flags& own,
                                                 const std::vector<std::uint64_t>& numbers,
                                                 const Reals& reals) {
  std::vector<meshing::gmf::ModelRow> picked;
  for (std::size_t i = 0; i < records.size(); ++i)
    if (own[i]) picked.push_back({numbers[records[i].vertex], records[i].id, reals(records[i])});
  return picked;
}

}  // namespace

OwnEntities own_entities(const MeshPiece& piece, const PieceNumbers& numbers) {
  const meshing::MeshData& mesh = piece.mesh;
  const PieceShare& share = numbers.share;
  OwnEntities own;
  own.points = pick_values(mesh.points, share.points);
  own.point_refs = pick_values(mesh.point_refs, share.points);
  pick(mesh.triangles, mesh.triangle_refs, share.triangles, numbers.points, own.triangles, own.triangle_refs);
  pick(mesh.edges, mesh.edge_refs, share.edges, numbers.points, own.edges, own.edge_refs);
  own.corners = pick_points(mesh.corners, share.corners, numbers.points);
  own.required_points = pick_points(mesh.required_points, share.required_points, numbers.points);
  own.ridges = pick_marks(mesh.ridges, share.edges, numbers.first.edges);
  own.required_edges = pick_marks(mesh.required_edges, share.edges, numbers.first.edges);
  own.required_triangles = pick_marks(mesh.required_triangles, share.triangles, numbers.first.triangles);
  using On = meshing::Association;
  using Reals = std::array<double, 3>;
  own.on_nodes = pick_records(mesh.association.nodes, share.on_nodes, numbers.points,
                              [](const On::OnNode&) { return Reals{}; });
  own.on_edges =
      pick_records(mesh.association.edges, share.on_edges, numbers.points, [](const On::OnEdge& r) {
        return Reals{r.t, r.last};
      });
  own.on_faces =
      pick_records(mesh.association.faces, share.on_faces, numbers.points, [](const On::OnFace& r) {
        return Reals{r.u, r.v, r.last};
      });
  return own;
}

meshing::LogMetricField own_log_metrics(const MeshPiece& piece, const PieceNumbers& numbers) {
  return pick_values(piece.log_metrics, numbers.share.points);
}

std::vector<std::array<std::uint64_t, 4>> own_tets(const MeshPiece& piece, const PieceNumbers& numbers,
                                                   std::size_t first, std::size_t count) {
  std::vector<std::array<std::uint64_t, 4>> own(count);
  for (std::size_t i = 0; i < count; ++i) own[i] = renumbered(piece.mesh.tets[first + i], numbers.points);
  return own;
}

}  // namespace weft::partition
