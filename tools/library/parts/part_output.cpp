#include "tools/library/parts/part_output.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>

#include "partition/output/numbering.h"
#include "tools/library/parts/part_ghosts.h"
#include "tools/library/parts/piece_moves.h"

namespace weft::tools {
namespace {

using partition::MeshPiece;
using partition::Peers;

struct PieceSize {
  std::uint64_t subdomain, tets;
};

/// The rank of every subdomain: they follow each other, cut where the shares of tets say. The same on all
/// ranks.
std::vector<int> ranks_of_subdomains(Peers& peers, const std::vector<MeshPiece>& pieces) {
  std::vector<PieceSize> mine;
  for (const MeshPiece& piece : pieces)
    mine.push_back({std::uint64_t{piece.subdomain.value}, piece.mesh.tets.size()});
  std::vector<std::uint64_t> tets;
  std::uint64_t total = 0;
  for (const auto& of_rank : partition::allgather(peers, mine))
    for (const PieceSize& size : of_rank) {
      if (tets.size() <= size.subdomain) tets.resize(size.subdomain + 1);
      tets[size.subdomain] = size.tets;
      total += size.tets;
    }
  std::vector<int> ranks;
  std::uint64_t before = 0;
  for (const std::uint64_t count : tets) {
    const std::uint64_t middle = before + count / 2;
    const auto rank = static_cast<int>(middle * static_cast<std::uint64_t>(peers.ranks()) /
                                       std::max<std::uint64_t>(total, 1));
    ranks.push_back(std::min(rank, peers.ranks() - 1));
    before += count;
  }
  return ranks;
}

/// The pieces of one rank as one mesh.
class Merger {
 public:
  Merger(Part& part, std::vector<Tensor>& log_metrics, const std::vector<int>& rank_of)
      : part_(part), log_metrics_(log_metrics), rank_of_(rank_of) {}

  void add(const MeshPiece& piece, const partition::PieceNumbers& numbers) {
    add_points(piece, numbers);
    Mesh& mesh = part_.mesh;
    for (std::size_t t = 0; t < piece.mesh.tets.size(); ++t) {
      mesh.tets.push_back(local_of(piece.mesh.tets[t]));
      mesh.tet_refs.push_back(piece.mesh.tet_refs[t]);
    }
    add_triangles(piece.mesh);
    add_edges(piece.mesh);
    for (const std::uint32_t v : piece.mesh.corners) add_once(local_[v], corners_, mesh.corners);
    for (const std::uint32_t v : piece.mesh.required_points)
      add_once(local_[v], required_, mesh.required_points);
  }

 private:
  void add_points(const MeshPiece& piece, const partition::PieceNumbers& numbers) {
    std::vector<int> owners(piece.ids.size(), rank_of(piece.subdomain));
    auto lowest = std::vector<std::uint64_t>(piece.ids.size(), std::uint64_t{piece.subdomain.value});
    for (const auto& shared : piece.shared) {
      const auto other = std::uint64_t{shared.other.value};
      if (other >= lowest[shared.vertex]) continue;
      lowest[shared.vertex] = other;
      owners[shared.vertex] = rank_of_[other];
    }
    local_.resize(piece.ids.size());
    for (std::size_t v = 0; v < piece.ids.size(); ++v) {
      const auto [at, added] =
          index_of_.try_emplace(numbers.points[v], static_cast<std::uint32_t>(part_.ids.size()));
      local_[v] = at->second;
      if (!added) continue;
      part_.ids.push_back(numbers.points[v]);
      part_.owners.push_back(owners[v]);
      part_.mesh.points.push_back(piece.mesh.points[v]);
      part_.mesh.point_refs.push_back(piece.mesh.point_refs[v]);
      log_metrics_.push_back(piece.log_metrics[v]);
    }
  }

  int rank_of(partition::SubdomainId subdomain) const { return rank_of_[subdomain.value]; }

  template <std::size_t N>
  std::array<std::uint32_t, N> local_of(const std::array<std::uint32_t, N>& entity) const {
    std::array<std::uint32_t, N> local{};
    for (std::size_t i = 0; i < N; ++i) local[i] = local_[entity[i]];
    return local;
  }

  template <std::size_t N>
  static std::array<std::uint32_t, N> sorted(std::array<std::uint32_t, N> entity) {
    std::ranges::sort(entity);
    return entity;
  }

  static void add_once(std::uint32_t v, std::map<std::uint32_t, bool>& known,
                       std::vector<std::uint32_t>& list) {
    if (known.try_emplace(v, true).second) list.push_back(v);
  }

  void add_triangles(const Mesh& from) {
    Mesh& mesh = part_.mesh;
    std::vector<bool> required(from.triangles.size());
    for (const std::uint32_t t : from.required_triangles) required[t] = true;
    for (std::size_t t = 0; t < from.triangles.size(); ++t) {
      const auto triangle = local_of(from.triangles[t]);
      if (!triangles_.try_emplace(sorted(triangle), true).second) continue;
      if (required[t]) mesh.required_triangles.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
      mesh.triangles.push_back(triangle);
      mesh.triangle_refs.push_back(from.triangle_refs[t]);
    }
  }

  void add_edges(const Mesh& from) {
    Mesh& mesh = part_.mesh;
    std::vector<bool> ridge(from.edges.size()), required(from.edges.size());
    for (const std::uint32_t e : from.ridges) ridge[e] = true;
    for (const std::uint32_t e : from.required_edges) required[e] = true;
    for (std::size_t e = 0; e < from.edges.size(); ++e) {
      const auto edge = local_of(from.edges[e]);
      if (!edges_.try_emplace(sorted(edge), true).second) continue;
      const auto number = static_cast<std::uint32_t>(mesh.edges.size());
      if (ridge[e]) mesh.ridges.push_back(number);
      if (required[e]) mesh.required_edges.push_back(number);
      mesh.edges.push_back(edge);
      mesh.edge_refs.push_back(from.edge_refs[e]);
    }
  }

  Part& part_;
  std::vector<Tensor>& log_metrics_;
  const std::vector<int>& rank_of_;
  std::vector<std::uint32_t> local_;  ///< of the piece's points in the part
  std::unordered_map<std::uint64_t, std::uint32_t> index_of_;
  std::map<std::array<std::uint32_t, 3>, bool> triangles_;
  std::map<std::array<std::uint32_t, 2>, bool> edges_;
  std::map<std::uint32_t, bool> corners_, required_;
};

/// Which other ranks have a vertex of the part: those of the subdomains that share it.
std::vector<std::vector<int>> holders_of(const std::vector<MeshPiece>& pieces,
                                         const partition::Numbering& numbering,
                                         const std::vector<int>& rank_of, int mine, const Part& part) {
  std::unordered_map<std::uint64_t, std::vector<int>> by_id;
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (const auto& shared : pieces[p].shared) {
      const int rank = rank_of[shared.other.value];
      if (rank == mine) continue;
      std::vector<int>& ranks = by_id[numbering.pieces[p].points[shared.vertex]];
      if (std::ranges::find(ranks, rank) == ranks.end()) ranks.push_back(rank);
    }
  std::vector<std::vector<int>> holders(part.ids.size());
  for (std::size_t v = 0; v < part.ids.size(); ++v)
    if (const auto at = by_id.find(part.ids[v]); at != by_id.end()) holders[v] = std::move(at->second);
  return holders;
}

}  // namespace

PartWithMetric part_of_pieces(Peers& peers, graph::dataflow::RankExchange& exchange,
                              std::vector<MeshPiece> pieces, bool ghosts) {
  const std::vector<int> rank_of = ranks_of_subdomains(peers, pieces);
  pieces = move_pieces(exchange, std::move(pieces),
                       [&](const MeshPiece& piece) { return rank_of[piece.subdomain.value]; });
  const partition::Numbering numbering = partition::number_pieces(peers, pieces);
  PartWithMetric result;
  std::vector<Tensor> log_metrics;
  Merger merger(result.part, log_metrics, rank_of);
  for (std::size_t p = 0; p < pieces.size(); ++p) merger.add(pieces[p], numbering.pieces[p]);
  result.part.num_own_tets = result.part.mesh.tets.size();
  if (ghosts) {
    const auto holders = holders_of(pieces, numbering, rank_of, peers.rank(), result.part);
    add_ghosts(peers, holders, result.part, log_metrics);
  }
  result.metric = Metric::from_logarithms(std::move(log_metrics));
  return result;
}

}  // namespace weft::tools
