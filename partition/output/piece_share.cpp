// Vertices know their holders; other entities that may be in several pieces ask at their homes.
#include "partition/output/piece_share.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "partition/communication/home_rank.h"

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

/// Entities of all pieces here that may be in other pieces, each with the flag that its answer goes into.
template <std::size_t N>
class Candidates {
 public:
  /// Sets the flags of entities that only this piece can have; keeps `flags` to set the others.
  void add(const MeshPiece& piece, const std::vector<std::uint8_t>& shared,
           const std::vector<std::array<std::uint32_t, N>>& entities, std::vector<std::uint8_t>& flags) {
    flags.assign(entities.size(), 1);
    for (std::size_t e = 0; e < entities.size(); ++e) {
      EntityKey<N> key;
      bool all_shared = true;
      for (std::size_t i = 0; i < N; ++i) {
        key[i] = piece.ids[entities[e][i]];
        all_shared = all_shared && shared[entities[e][i]] != 0;
      }
      if (!all_shared) continue;
      holdings_.push_back({sorted_key<N>(key), piece.subdomain.value});
      flags_.push_back(&flags[e]);
    }
  }

  void decide(Peers& peers) {
    const std::vector<std::uint8_t> answers = held_by_no_lower<N>(peers, holdings_);
    for (std::size_t i = 0; i < answers.size(); ++i) *flags_[i] = answers[i];
  }

 private:
  std::vector<Holding<N>> holdings_;
  std::vector<std::uint8_t*> flags_;
};

/// Where vertices lie on the model: records of pieces here that other pieces may have too.
class ModelCandidates {
 public:
  void add(const MeshPiece& piece, const std::vector<std::uint8_t>& shared, PieceShare& share) {
    const meshing::Association& on = piece.mesh.association;
    std::vector<std::uint64_t> kinds(shared.size(), kNone);
    std::uint64_t kind = 0;
    const auto add_records = [&](const auto& records, std::vector<std::uint8_t>& flags) {
      flags.assign(records.size(), 1);
      for (std::size_t i = 0; i < records.size(); ++i) {
        const auto& r = records[i];
        kinds[r.vertex] = std::min(kinds[r.vertex], kind);
        if (!shared[r.vertex]) continue;
        const auto entity = GlobalId::from_value(kind << 32 | static_cast<std::uint32_t>(r.id));
        records_.push_back({{piece.ids[r.vertex], entity}, piece.subdomain.value});
        record_flags_.push_back(&flags[i]);
      }
      ++kind;
    };
    add_records(on.nodes, share.on_nodes);
    add_records(on.edges, share.on_edges);
    add_records(on.faces, share.on_faces);
    share.on_model.assign(shared.size(), 0);
    for (std::size_t v = 0; v < shared.size(); ++v) {
      if (kinds[v] == kNone) continue;
      share.on_model[v] = 1;
      if (!shared[v]) continue;
      vertices_.push_back({{piece.ids[v]}, kinds[v] << 32 | piece.subdomain.value});  // the lowest kind first
      vertex_flags_.push_back(&share.on_model[v]);
    }
  }

  void decide(Peers& peers) {
    const std::vector<std::uint8_t> records = held_by_no_lower<2>(peers, records_);
    for (std::size_t i = 0; i < records.size(); ++i) *record_flags_[i] = records[i];
    const std::vector<std::uint8_t> vertices = held_by_no_lower<1>(peers, vertices_);
    for (std::size_t i = 0; i < vertices.size(); ++i) *vertex_flags_[i] = vertices[i];
  }

 private:
  static constexpr std::uint64_t kNone = 3;
  std::vector<Holding<2>> records_;
  std::vector<Holding<1>> vertices_;
  std::vector<std::uint8_t*> record_flags_, vertex_flags_;
};

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
  Candidates<3> triangles;
  Candidates<2> edges;
  Candidates<1> corners, required_points;
  ModelCandidates on_model;
  for (std::size_t p = 0; p < mine.size(); ++p) {
    const meshing::MeshData& mesh = mine[p].mesh;
    const std::vector<std::uint8_t> shared = shared_flags(mine[p]);
    shares[p].points = owned_points(mine[p]);
    triangles.add(mine[p], shared, mesh.triangles, shares[p].triangles);
    edges.add(mine[p], shared, mesh.edges, shares[p].edges);
    corners.add(mine[p], shared, as_entities(mesh.corners), shares[p].corners);
    required_points.add(mine[p], shared, as_entities(mesh.required_points), shares[p].required_points);
    on_model.add(mine[p], shared, shares[p]);
  }
  triangles.decide(peers);
  edges.decide(peers);
  corners.decide(peers);
  required_points.decide(peers);
  on_model.decide(peers);
  for (std::size_t p = 0; p < mine.size(); ++p)
    if (!mine[p].own_points.empty()) keep_given(mine[p], shares[p]);
  return shares;
}

}  // namespace weft::partition
