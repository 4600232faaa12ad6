#include "tools/library/parts/piece_moves.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "engine/base/serialize.h"

namespace weft::tools {

using partition::MeshPiece;

namespace {

template <class Archive>
void pack(Archive& archive, MeshPiece& p) {
  meshing::MeshData& m = p.mesh;
  archive(p.subdomain, m.points, m.point_refs, m.tets, m.tet_refs, m.triangles, m.triangle_refs, m.edges,
          m.edge_refs, m.corners, m.required_points, m.ridges, m.required_edges, m.required_triangles,
          p.log_metrics, p.ids, p.shared, p.own_points, p.own_edges);
}

}  // namespace

std::vector<MeshPiece> gather_pieces(graph::dataflow::RankExchange& exchange, std::vector<MeshPiece> mine) {
  std::vector<engine::Payload> to_each(static_cast<std::size_t>(exchange.runtime().ranks()));
  engine::Packer packer(true);
  std::uint64_t count = mine.size();
  packer(count);
  for (MeshPiece& piece : mine) pack(packer, piece);
  to_each[0] = packer.take();
  std::vector<engine::Payload> arrived = exchange.exchange(std::move(to_each));
  std::vector<MeshPiece> all;
  if (exchange.runtime().rank().value != 0) return all;
  for (engine::Payload& payload : arrived) {
    engine::Unpacker unpacker(std::move(payload));
    unpacker(count);
    for (std::uint64_t i = 0; i < count; ++i) pack(unpacker, all.emplace_back());
    unpacker.finish();
  }
  std::ranges::sort(all, {}, &MeshPiece::subdomain);
  return all;
}

}  // namespace weft::tools
