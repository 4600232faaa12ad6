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
          p.log_metrics, p.ids, p.shared);
}

}  // namespace

std::vector<MeshPiece> move_pieces(graph::dataflow::RankExchange& exchange, std::vector<MeshPiece> mine,
                                   const std::function<int(const MeshPiece&)>& to) {
  const auto ranks = static_cast<std::size_t>(exchange.runtime().ranks());
  std::vector<std::vector<MeshPiece*>> of_rank(ranks);
  for (MeshPiece& piece : mine) of_rank.at(static_cast<std::size_t>(to(piece))).push_back(&piece);
  std::vector<engine::Payload> to_each(ranks);
  for (std::size_t r = 0; r < ranks; ++r) {
    engine::Packer packer(true);
    std::uint64_t count = of_rank[r].size();
    packer(count);
    for (MeshPiece* piece : of_rank[r]) pack(packer, *piece);
    to_each[r] = packer.take();
  }
  mine.clear();
  std::vector<MeshPiece> here;
  for (engine::Payload& payload : exchange.exchange(std::move(to_each))) {
    engine::Unpacker unpacker(std::move(payload));
    std::uint64_t count = 0;
    unpacker(count);
    for (std::uint64_t i = 0; i < count; ++i) pack(unpacker, here.emplace_back());
    unpacker.finish();
  }
  std::ranges::sort(here, {}, &MeshPiece::subdomain);
  return here;
}

std::vector<MeshPiece> gather_pieces(graph::dataflow::RankExchange& exchange, std::vector<MeshPiece> mine) {
  return move_pieces(exchange, std::move(mine), [](const MeshPiece&) { return 0; });
}

}  // namespace weft::tools
