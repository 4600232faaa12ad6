// Vertices know their holders; other entities that may be in several pieces ask at their homes.
#include "partition/output/piece_share.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "meshing/base/parallel.h"
#include "partition/output/undecided.h"

namespace weft::partition {
namespace {

std::vector<std::uint8_t> owned_points(const MeshPiece& piece) {
  if (!piece.own_points.empty()) return piece.own_points;
  std::vector<std::uint8_t> owned(piece.mesh.points.size(), 1);
  for (const auto& [vertex, other] : piece.shared) {
    if (other < piece.subdomain) owned[vertex] = 0;
  }
  return owned;
}

enum SharedKind : std::uint64_t { kTriangle, kEdge, kCorner, kRequiredPoint, kRecordOnModel, kPointOnModel };

/// Sets the flags of entities that only this piece can have; keeps `flags` to set the others.
template <std::size_t N>
void add_entities(SharedKind kind, const MeshPiece& piece, const std::vector<std::uint8_t>& shared,
                  const std::vector<std::array<std::uint32_t, N>>& entities, std::vector<std::uint8_t>& flags,
                  Undecided<3>& undecided) {
  flags.assign(entities.size(), 1);
  for (std::size_t e = 0; e < entities.size(); ++e) {
    EntityKey<N> key;
    bool all_shared = true;
    for (std::size_t i = 0; i < N; ++i) {
      key[i] = piece.ids[entities[e][i]];
      all_shared = all_shared && shared[entities[e][i]] != 0;
    }
    if (all_shared) undecided.add(kind, sorted_key<N>(key), piece.subdomain.value, flags[e]);
  }
}

/// Where vertices lie on the model: records of a piece that other pieces may have too, and vertices of them.
void add_on_model(const MeshPiece& piece, const std::vector<std::uint8_t>& shared, PieceShare& share,
                  Undecided<3>& undecided) {
  constexpr std::uint64_t kOffModel = 3;
  const meshing::Association& on = piece.mesh.association;
  std::vector<std::uint64_t> kinds(shared.size(), kOffModel);
  std::uint64_t kind = 0;
  const auto add_records = [&](const auto& records, std::vector<std::uint8_t>& flags) {
    flags.assign(records.size(), 1);
    for (std::size_t i = 0; i < records.size(); ++i) {
      const auto& r = records[i];
      kinds[r.vertex] = std::min(kinds[r.vertex], kind);
      if (!shared[r.vertex]) continue;
      const auto entity = GlobalId::from_value(kind << 32 | static_cast<std::uint32_t>(r.id));
      undecided.add(kRecordOnModel, EntityKey<2>{piece.ids[r.vertex], entity}, piece.subdomain.value,
                    flags[i]);
    }
    ++kind;
  };
  add_records(on.nodes, share.on_nodes);
  add_records(on.edges, share.on_edges);
  add_records(on.faces, share.on_faces);
  share.on_model.assign(shared.size(), 0);
  for (std::size_t v = 0; v < shared.size(); ++v) {
    if (kinds[v] == kOffModel) continue;
    share.on_model[v] = 1;
    const std::uint64_t lowest_kind_first = kinds[v] << 32 | piece.subdomain.value;
    if (shared[v])
      undecided.add(kPointOnModel, EntityKey<1>{piece.ids[v]}, lowest_kind_first, share.on_model[v]);
  }
}

std::vector<std::array<std::uint32_t, 1>> as_entities(const std::vector<std::uint32_t>& points) {
  std::vector<std::array<std::uint32_t, 1>> entities;
  for (const std::uint32_t point : points) entities.push_back({point});
  return entities;
}

/// Lists of points go with the points.
void keep_given(const MeshPiece& piece, PieceShare& share) {
  share.edges = piece.own_edges;
  for (std::size_t i = 0; i < share.corners.size(); ++i)
    share.corners[i] = piece.own_points[piece.mesh.corners[i]];
  for (std::size_t i = 0; i < share.required_points.size(); ++i)
    share.required_points[i] = piece.own_points[piece.mesh.required_points[i]];
}

}  // namespace

std::vector<std::uint8_t> shared_flags(const MeshPiece& piece) {
  std::vector<std::uint8_t> flags(piece.mesh.points.size(), 0);
  for (const auto& [vertex, other] : piece.shared) flags[vertex] = 1;
  return flags;
}

std::vector<PieceShare> shares_of(Peers& peers, std::span<const MeshPiece> mine) {
  std::vector<PieceShare> shares(mine.size());
  std::vector<Undecided<3>> undecided(mine.size());
  meshing::for_each_large(mine.size(), [&](std::size_t p) {
    const MeshPiece& piece = mine[p];
    const meshing::MeshData& mesh = piece.mesh;
    const std::vector<std::uint8_t> shared = shared_flags(piece);
    PieceShare& share = shares[p];
    share.points = owned_points(piece);
    const auto add = [&](SharedKind kind, const auto& entities, std::vector<std::uint8_t>& flags) {
      add_entities(kind, piece, shared, entities, flags, undecided[p]);
    };
    add(kTriangle, mesh.triangles, share.triangles);
    add(kEdge, mesh.edges, share.edges);
    add(kCorner, as_entities(mesh.corners), share.corners);
    add(kRequiredPoint, as_entities(mesh.required_points), share.required_points);
    add_on_model(piece, shared, share, undecided[p]);
  });
  Undecided<3>::decide(peers, std::move(undecided));
  for (std::size_t p = 0; p < mine.size(); ++p)
    if (!mine[p].own_points.empty()) keep_given(mine[p], shares[p]);
  return shares;
}

}  // namespace weft::partition
