#include "tools/library/parts/part_output.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "partition/output/numbering.h"
#include "tools/library/parts/part_ghosts.h"
#include "tools/library/parts/part_numbers.h"

namespace weft::tools {
namespace {

using partition::MeshPiece;
using partition::Peers;

constexpr std::uint32_t kRequired = 1, kRidge = 2, kCorner = 4;

struct ResultPoint {
  std::uint64_t id;
  Point x;
  Tensor log_metric;
  std::int32_t ref;
  std::uint32_t marks;
};

/// A tet, triangle or edge by the numbers of its points in the whole mesh.
template <std::size_t N>
struct ResultEntity {
  std::array<std::uint64_t, N> ids;
  std::int32_t ref;
  std::uint32_t marks;
};

template <std::size_t N>
std::array<std::uint32_t, N> sorted(std::array<std::uint32_t, N> entity) {
  std::ranges::sort(entity);
  return entity;
}

/// What one rank sends to one other.
struct Outgoing {
  std::vector<ResultPoint> points;
  std::vector<ResultEntity<4>> tets;
  std::vector<ResultEntity<3>> triangles;
  std::vector<ResultEntity<2>> edges;
};

/// The entities of a piece that go with their tets, by their points in the piece.
template <std::size_t N>
using Listed = std::map<std::array<std::uint32_t, N>, std::size_t>;

template <std::size_t N>
Listed<N> listed(const std::vector<std::array<std::uint32_t, N>>& entities) {
  Listed<N> places;
  for (std::size_t e = 0; e < entities.size(); ++e) places.emplace(sorted(entities[e]), e);
  return places;
}

/// Cuts one piece: its tets, in their order in the whole mesh, go to the ranks in equal shares.
class Cutter {
 public:
  Cutter(const MeshPiece& piece, const partition::PieceNumbers& numbers, std::vector<Outgoing>& to_each)
      : piece_(piece), numbers_(numbers), to_each_(to_each), marks_(piece.ids.size()) {
    for (const std::uint32_t v : piece.mesh.corners) marks_[v] |= kCorner;
    for (const std::uint32_t v : piece.mesh.required_points) marks_[v] |= kRequired;
    mark(piece.mesh.required_triangles, piece.mesh.triangles.size(), kRequired, triangle_marks_);
    mark(piece.mesh.required_edges, piece.mesh.edges.size(), kRequired, edge_marks_);
    mark(piece.mesh.ridges, piece.mesh.edges.size(), kRidge, edge_marks_);
    triangles_ = listed(piece.mesh.triangles);
    edges_ = listed(piece.mesh.edges);
  }

  void cut(std::uint64_t total) {
    const Mesh& mesh = piece_.mesh;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const std::uint64_t number = numbers_.first.tets + t;
      const auto rank = static_cast<std::size_t>(number * to_each_.size() / total);
      if (rank != rank_) begin_rank(rank);
      add_tet(mesh.tets[t], mesh.tet_refs[t]);
    }
  }

 private:
  static void mark(const std::vector<std::uint32_t>& list, std::size_t size, std::uint32_t bit,
                   std::vector<std::uint32_t>& marks) {
    marks.resize(size);
    for (const std::uint32_t i : list) marks[i] |= bit;
  }

  /// The ranks of a piece's tets ascend, so what has been sent to one need be known for one at a time.
  void begin_rank(std::size_t rank) {
    rank_ = rank;
    sent_points_.clear();
    sent_triangles_.clear();
    sent_edges_.clear();
  }

  template <std::size_t N>
  std::array<std::uint64_t, N> ids_of(const std::array<std::uint32_t, N>& entity) const {
    std::array<std::uint64_t, N> ids{};
    for (std::size_t i = 0; i < N; ++i) ids[i] = numbers_.points[entity[i]];
    return ids;
  }

  void add_tet(const std::array<std::uint32_t, 4>& tet, std::int32_t ref) {
    Outgoing& out = to_each_[rank_];
    out.tets.push_back({ids_of(tet), ref, 0});
    for (const std::uint32_t v : tet)
      if (sent_points_.insert(v).second)
        out.points.push_back({numbers_.points[v], piece_.mesh.points[v], piece_.log_metrics[v],
                              piece_.mesh.point_refs[v], marks_[v]});
    for (std::size_t f = 0; f < 4; ++f) add_triangle({tet[(f + 1) % 4], tet[(f + 2) % 4], tet[(f + 3) % 4]});
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b) add_edge({tet[a], tet[b]});
  }

  void add_triangle(const std::array<std::uint32_t, 3>& face) {
    const auto at = triangles_.find(sorted(face));
    if (at == triangles_.end() || !sent_triangles_.insert(at->second).second) return;
    to_each_[rank_].triangles.push_back({ids_of(piece_.mesh.triangles[at->second]),
                                         piece_.mesh.triangle_refs[at->second], triangle_marks_[at->second]});
  }

  void add_edge(const std::array<std::uint32_t, 2>& edge) {
    const auto at = edges_.find(sorted(edge));
    if (at == edges_.end() || !sent_edges_.insert(at->second).second) return;
    to_each_[rank_].edges.push_back(
        {ids_of(piece_.mesh.edges[at->second]), piece_.mesh.edge_refs[at->second], edge_marks_[at->second]});
  }

  const MeshPiece& piece_;
  const partition::PieceNumbers& numbers_;
  std::vector<Outgoing>& to_each_;
  std::vector<std::uint32_t> marks_, triangle_marks_, edge_marks_;
  Listed<3> triangles_;
  Listed<2> edges_;
  std::size_t rank_ = ~std::size_t{0};
  std::unordered_set<std::uint32_t> sent_points_;
  std::unordered_set<std::size_t> sent_triangles_, sent_edges_;
};

/// All ranks: one kind of what goes out; what has come in, in the order of the ranks.
template <class Record>
std::vector<Record> exchanged(Peers& peers, std::vector<Outgoing>& to_each,
                              std::vector<Record> Outgoing::*kind) {
  std::vector<std::vector<Record>> lists;
  for (Outgoing& out : to_each) lists.push_back(std::move(out.*kind));
  std::vector<Record> all;
  for (const auto& of_rank : partition::all_to_all(peers, lists))
    all.insert(all.end(), of_rank.begin(), of_rank.end());
  return all;
}

/// What has come here becomes a mesh with local numbers.
class Builder {
 public:
  Builder(Part& part, std::vector<Tensor>& log_metrics) : part_(part), log_metrics_(log_metrics) {}

  void add_points(std::vector<ResultPoint> points) {
    std::ranges::stable_sort(points, {}, &ResultPoint::id);
    Mesh& mesh = part_.mesh;
    for (const ResultPoint& p : points) {
      if (!part_.ids.empty() && part_.ids.back() == p.id) continue;
      const auto local = static_cast<std::uint32_t>(part_.ids.size());
      index_.emplace(p.id, local);
      part_.ids.push_back(p.id);
      mesh.points.push_back(p.x);
      mesh.point_refs.push_back(p.ref);
      log_metrics_.push_back(p.log_metric);
      if (p.marks & kCorner) mesh.corners.push_back(local);
      if (p.marks & kRequired) mesh.required_points.push_back(local);
    }
  }

  void add_tets(const std::vector<ResultEntity<4>>& tets) {
    for (const ResultEntity<4>& tet : tets) {
      part_.mesh.tets.push_back(local_of(tet.ids));
      part_.mesh.tet_refs.push_back(tet.ref);
    }
  }

  void add_triangles(const std::vector<ResultEntity<3>>& triangles) {
    Mesh& mesh = part_.mesh;
    std::map<std::array<std::uint32_t, 3>, bool> known;
    for (const ResultEntity<3>& triangle : triangles) {
      const auto local = local_of(triangle.ids);
      if (!known.try_emplace(sorted(local), true).second) continue;
      if (triangle.marks & kRequired)
        mesh.required_triangles.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
      mesh.triangles.push_back(local);
      mesh.triangle_refs.push_back(triangle.ref);
    }
  }

  void add_edges(const std::vector<ResultEntity<2>>& edges) {
    Mesh& mesh = part_.mesh;
    std::map<std::array<std::uint32_t, 2>, bool> known;
    for (const ResultEntity<2>& edge : edges) {
      const auto local = local_of(edge.ids);
      if (!known.try_emplace(sorted(local), true).second) continue;
      const auto number = static_cast<std::uint32_t>(mesh.edges.size());
      if (edge.marks & kRidge) mesh.ridges.push_back(number);
      if (edge.marks & kRequired) mesh.required_edges.push_back(number);
      mesh.edges.push_back(local);
      mesh.edge_refs.push_back(edge.ref);
    }
  }

 private:
  template <std::size_t N>
  std::array<std::uint32_t, N> local_of(const std::array<std::uint64_t, N>& ids) const {
    std::array<std::uint32_t, N> local{};
    for (std::size_t i = 0; i < N; ++i) local[i] = index_.at(ids[i]);
    return local;
  }

  Part& part_;
  std::vector<Tensor>& log_metrics_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_;
};

struct Holder {
  std::uint64_t id;
  std::int64_t rank;
};

/// All ranks: fills the part's owners, the lowest rank that has each point; returns the other ranks that have
/// it.
std::vector<std::vector<int>> find_holders(Peers& peers, Part& part) {
  std::uint64_t largest = 0;
  for (const std::uint64_t id : part.ids) largest = std::max(largest, id);
  const IdHomes homes(peers, largest);
  IdMail<std::uint64_t> mail(peers, homes);
  for (const std::uint64_t id : part.ids) mail.add(id, id);
  const auto arrived = mail.deliver();
  std::unordered_map<std::uint64_t, std::vector<int>> ranks_of;
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (const std::uint64_t id : arrived[r]) ranks_of[id].push_back(static_cast<int>(r));
  // Points of one rank alone need no line; of the others each holder gets one for every holder.
  std::vector<std::vector<Holder>> lines(arrived.size());
  for (const auto& [id, ranks] : ranks_of)
    if (ranks.size() > 1)
      for (const int to : ranks)
        for (const int rank : ranks) lines[static_cast<std::size_t>(to)].push_back({id, rank});
  std::unordered_map<std::uint64_t, std::vector<int>> others;
  part.owners.assign(part.ids.size(), peers.rank());
  for (const auto& of_home : partition::all_to_all(peers, lines))
    for (const Holder& line : of_home) others[line.id].push_back(static_cast<int>(line.rank));
  std::vector<std::vector<int>> holders(part.ids.size());
  for (std::size_t v = 0; v < part.ids.size(); ++v) {
    const auto at = others.find(part.ids[v]);
    if (at == others.end()) continue;
    part.owners[v] = std::ranges::min(at->second);
    for (const int rank : at->second)
      if (rank != peers.rank()) holders[v].push_back(rank);
  }
  return holders;
}

}  // namespace

PartWithMetric part_of_pieces(Peers& peers, const std::vector<MeshPiece>& pieces, bool ghosts) {
  const partition::Numbering numbering = partition::number_pieces(peers, pieces);
  std::vector<Outgoing> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t p = 0; p < pieces.size(); ++p)
    Cutter(pieces[p], numbering.pieces[p], to_each).cut(numbering.totals.tets);
  PartWithMetric result;
  std::vector<Tensor> log_metrics;
  Builder builder(result.part, log_metrics);
  builder.add_points(exchanged(peers, to_each, &Outgoing::points));
  builder.add_tets(exchanged(peers, to_each, &Outgoing::tets));
  builder.add_triangles(exchanged(peers, to_each, &Outgoing::triangles));
  builder.add_edges(exchanged(peers, to_each, &Outgoing::edges));
  result.part.num_own_tets = result.part.mesh.tets.size();
  const auto holders = find_holders(peers, result.part);
  if (ghosts) add_ghosts(peers, holders, result.part, log_metrics);
  result.metric = Metric::from_logarithms(std::move(log_metrics));
  return result;
}

}  // namespace weft::tools
