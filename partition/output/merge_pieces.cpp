// The numbers that the writer uses too, on one rank.
#include "partition/output/merge_pieces.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/communication/point_limit.h"
#include "partition/output/numbering.h"
#include "partition/output/own_entities.h"

namespace weft::partition {
namespace {

template <class T>
void append(const std::vector<T>& from, std::vector<T>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

void append_narrow(const std::vector<std::uint64_t>& from, std::vector<std::uint32_t>& to) {
  for (const std::uint64_t number : from) to.push_back(static_cast<std::uint32_t>(number));
}

template <std::size_t N>
void append_narrow(const std::vector<std::array<std::uint64_t, N>>& from,
                   std::vector<std::array<std::uint32_t, N>>& to) {
  for (const auto& entity : from) {
    std::array<std::uint32_t, N> narrow;
    for (std::size_t i = 0; i < N; ++i) narrow[i] = static_cast<std::uint32_t>(entity[i]);
    to.push_back(narrow);
  }
}

void append_on_model(const OwnEntities& own, meshing::Association& to) {
  const auto vertex = [](const meshing::gmf::ModelRow& r) { return static_cast<std::uint32_t>(r.vertex); };
  for (const auto& r : own.on_nodes) to.nodes.push_back({vertex(r), r.id});
  for (const auto& r : own.on_edges) to.edges.push_back({vertex(r), r.id, r.reals[0], r.reals[1]});
  for (const auto& r : own.on_faces)
    to.faces.push_back({vertex(r), r.id, r.reals[0], r.reals[1], r.reals[2]});
}

void append(const MeshPiece& piece, const PieceNumbers& numbers, MergedMesh& whole) {
  meshing::MeshData& mesh = whole.mesh;
  const OwnEntities own = own_entities(piece, numbers);
  append(own.points, mesh.points);
  append(own.point_refs, mesh.point_refs);
  append(own_log_metrics(piece, numbers), whole.log_metrics);
  append_narrow(own_tets(piece, numbers), mesh.tets);
  append(piece.mesh.tet_refs, mesh.tet_refs);
  append_narrow(own.triangles, mesh.triangles);
  append(own.triangle_refs, mesh.triangle_refs);
  append_narrow(own.edges, mesh.edges);
  append(own.edge_refs, mesh.edge_refs);
  append_narrow(own.corners, mesh.corners);
  append_narrow(own.required_points, mesh.required_points);
  append_narrow(own.ridges, mesh.ridges);
  append_narrow(own.required_edges, mesh.required_edges);
  append_narrow(own.required_triangles, mesh.required_triangles);
  append_on_model(own, mesh.association);
}

}  // namespace

MergedMesh merge_pieces(std::span<const MeshPiece> pieces) {
  SelfPeers alone;
  const Numbering numbering = number_pieces(alone, pieces);
  refuse_too_many_points(numbering.totals.points);
  std::vector<std::size_t> order(pieces.size());
  for (std::size_t p = 0; p < order.size(); ++p) order[p] = p;
  std::ranges::sort(order, {}, [&](std::size_t p) { return pieces[p].subdomain; });
  MergedMesh whole;
  for (const std::size_t p : order) append(pieces[p], numbering.pieces[p], whole);
  return whole;
}

}  // namespace weft::partition
