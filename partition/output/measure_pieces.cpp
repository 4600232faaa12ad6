// Sums of each piece by meshing's own formulas, added up in the order of the subdomains.
#include "partition/output/measure_pieces.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/measure_totals.h"
#include "partition/communication/home_rank.h"
#include "partition/communication/reduce.h"
#include "partition/communication/select.h"
#include "partition/output/piece_share.h"

namespace weft::partition {
namespace {

using meshing::EdgeLists;
using meshing::EdgeTotals;
using meshing::Histogram;
using meshing::Measures;
using meshing::Tet;
using meshing::TetTotals;

/// The part of a piece that is measured.
struct PieceMeasures {
  std::vector<Tet> tets;
  EdgeLists edges;                   ///< of the tets
  std::vector<std::uint8_t> counts;  ///< of edges.others: 1 where no lower subdomain measures the edge too
  std::uint64_t num_vertices = 0, num_triangles = 0;  ///< that no lower subdomain counts too
};

/// What the pieces' sums are put together of. The sums of one piece come first: doubles, whose order matters.
struct PieceSums {
  std::uint64_t subdomain;
  double volume, complexity, quality, length;
};

bool any_flag(std::span<const std::uint32_t> vertices, const std::vector<std::uint8_t>& flags) {
  return std::ranges::any_of(vertices, [&](std::uint32_t v) { return flags[v] != 0; });
}

/// Asks which edges with two shared ends a lower subdomain measures too.
void divide_edges(Peers& peers, std::span<const MeshPiece> mine, std::vector<PieceMeasures>& parts) {
  std::vector<Holding<2>> holdings;
  std::vector<std::uint8_t*> counts;
  for (std::size_t p = 0; p < mine.size(); ++p) {
    PieceMeasures& part = parts[p];
    const std::vector<std::uint8_t> shared = shared_flags(mine[p]);
    part.counts.assign(part.edges.others.size(), 1);
    for (std::size_t v = 0; v < shared.size(); ++v) {
      if (!shared[v]) continue;
      for (std::size_t e = part.edges.begins[v]; e < part.edges.begins[v + 1]; ++e) {
        if (!shared[part.edges.others[e]]) continue;
        const EntityKey<2> ends{mine[p].ids[v], mine[p].ids[part.edges.others[e]]};
        holdings.push_back({sorted_key<2>(ends), mine[p].subdomain.value});
        counts.push_back(&part.counts[e]);
      }
    }
  }
  const std::vector<std::uint8_t> lowest = held_by_no_lower<2>(peers, holdings);
  for (std::size_t i = 0; i < lowest.size(); ++i) *counts[i] = lowest[i];
}

/// Counts the vertices of the parts' tets, each in the lowest subdomain that has it.
void count_vertices_of_tets(Peers& peers, std::span<const MeshPiece> mine,
                            std::vector<PieceMeasures>& parts) {
  std::vector<Holding<1>> holdings;
  std::vector<std::size_t> pieces;
  for (std::size_t p = 0; p < mine.size(); ++p) {
    const std::vector<std::uint8_t> shared = shared_flags(mine[p]);
    std::vector<std::uint8_t> used(shared.size());
    for (const Tet& tet : parts[p].tets)
      for (const std::uint32_t v : tet) used[v] = 1;
    for (std::size_t v = 0; v < used.size(); ++v) {
      parts[p].num_vertices += used[v] && !shared[v];
      if (!used[v] || !shared[v]) continue;
      holdings.push_back({{mine[p].ids[v]}, mine[p].subdomain.value});
      pieces.push_back(p);
    }
  }
  const std::vector<std::uint8_t> lowest = held_by_no_lower<1>(peers, holdings);
  for (std::size_t i = 0; i < lowest.size(); ++i) parts[pieces[i]].num_vertices += lowest[i];
}

/// `flags`: nullptr for everything.
std::vector<PieceMeasures> parts_of(Peers& peers, std::span<const MeshPiece> mine, const VertexFlags* flags) {
  std::vector<PieceMeasures> parts(mine.size());
  const std::vector<PieceShare> shares = shares_of(peers, mine);
  for (std::size_t p = 0; p < mine.size(); ++p) {
    const meshing::MeshData& mesh = mine[p].mesh;
    for (const Tet& tet : mesh.tets)
      if (!flags || any_flag(tet, (*flags)[p])) parts[p].tets.push_back(tet);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      parts[p].num_triangles +=
          shares[p].triangles[t] && (!flags || any_flag(mesh.triangles[t], (*flags)[p]));
    if (!flags) parts[p].num_vertices = static_cast<std::uint64_t>(std::ranges::count(shares[p].points, 1));
    parts[p].edges = meshing::unique_edges(parts[p].tets, mesh.points.size());
  }
  if (flags) count_vertices_of_tets(peers, mine, parts);
  divide_edges(peers, mine, parts);
  return parts;
}

/// Everything that is summed over pieces.
struct Sums {
  Measures counts;  ///< the numbers of entities alone
  TetTotals tets;
  EdgeTotals edges;
  std::vector<PieceSums> pieces;
  std::vector<double> qualities;
};

Sums sum_here(std::span<const MeshPiece> mine, const std::vector<PieceMeasures>& parts) {
  Sums sums;
  std::vector<double> qualities;
  for (std::size_t p = 0; p < mine.size(); ++p) {
    const meshing::MeshData& mesh = mine[p].mesh;
    const TetTotals tets = sum_tets(parts[p].tets, mesh.points, mine[p].log_metrics, qualities);
    const EdgeTotals edges = sum_edges(parts[p].edges, parts[p].counts, mesh.points, mine[p].log_metrics);
    sums.qualities.insert(sums.qualities.end(), qualities.begin(), qualities.end());
    sums.pieces.push_back(
        {mine[p].subdomain.value, tets.volume, tets.complexity, tets.quality, edges.length});
    sums.tets += tets;
    sums.edges += edges;
    sums.counts.num_vertices += parts[p].num_vertices;
    sums.counts.num_triangles += parts[p].num_triangles;
    sums.counts.num_tets += parts[p].tets.size();
  }
  return sums;
}

/// Calls visit(count) for every count that adds up, in a fixed order.
template <class Visit>
void for_each_count(Sums& sums, const Visit& visit) {
  for (std::uint64_t* count : {&sums.counts.num_vertices, &sums.counts.num_triangles, &sums.counts.num_tets,
                               &sums.tets.below_01, &sums.tets.below_02, &sums.tets.above_08,
                               &sums.edges.edges, &sums.edges.unit, &sums.edges.shorter, &sums.edges.longer})
    visit(*count);
  for (Histogram* histogram :
       {&sums.tets.linear, &sums.tets.logarithmic, &sums.edges.linear, &sums.edges.logarithmic}) {
    visit(histogram->below);
    visit(histogram->above);
    for (std::uint64_t& count : histogram->counts) visit(count);
  }
}

void add_counts(Peers& peers, Sums& sums) {
  std::vector<std::uint64_t> counts;
  for_each_count(sums, [&](std::uint64_t& count) { counts.push_back(std::exchange(count, 0)); });
  counts = partition::sum(peers, counts);
  std::size_t next = 0;
  for_each_count(sums, [&](std::uint64_t& count) { count = counts[next++]; });
}

void add_extremes(Peers& peers, Sums& sums) {
  const std::vector<double> least = partition::min(
      peers, std::vector{sums.tets.quality_min, sums.edges.length_min, -sums.edges.length_max});
  sums.tets.quality_min = least[0];
  sums.edges.length_min = least[1];
  sums.edges.length_max = -least[2];
}

/// By subdomain, so that rounding does not depend on who has which.
void add_reals(Peers& peers, Sums& sums) {
  std::vector<PieceSums> all = allgather_joined(peers, sums.pieces);
  std::ranges::sort(all, {}, &PieceSums::subdomain);
  sums.tets.volume = sums.tets.complexity = sums.tets.quality = sums.edges.length = 0;
  for (const PieceSums& piece : all) {
    sums.tets.volume += piece.volume;
    sums.tets.complexity += piece.complexity;
    sums.tets.quality += piece.quality;
    sums.edges.length += piece.length;
  }
}

Measures measure_parts(Peers& peers, std::span<const MeshPiece> mine, const VertexFlags* flags) {
  Sums sums = sum_here(mine, parts_of(peers, mine, flags));
  add_counts(peers, sums);
  add_extremes(peers, sums);
  add_reals(peers, sums);
  Measures m = sums.counts;
  if (m.num_tets == 0) return m;
  put_tets(sums.tets, m.num_tets, m);
  put_edges(sums.edges, m);
  const std::array<std::uint64_t, 2> places = {meshing::quantile_place(m.num_tets, 0.01),
                                               meshing::quantile_place(m.num_tets, 0.001)};
  const std::vector<double> quantiles = select(peers, sums.qualities, places);
  m.quality_q01 = quantiles[0];
  m.quality_q001 = quantiles[1];
  return m;
}

}  // namespace

Measures measure_pieces(Peers& peers, std::span<const MeshPiece> mine) {
  return measure_parts(peers, mine, nullptr);
}

Measures measure_pieces(Peers& peers, std::span<const MeshPiece> mine, const VertexFlags& flags) {
  return measure_parts(peers, mine, &flags);
}

}  // namespace weft::partition
