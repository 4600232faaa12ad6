// Sums of each piece by meshing's own formulas, added up in the order of the subdomains.
#include "partition/output/measure_pieces.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "meshing/base/parallel.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/tet_tables.h"
#include "meshing/metric/measure_totals.h"
#include "partition/communication/reduce.h"
#include "partition/communication/select.h"
#include "partition/output/piece_share.h"
#include "partition/output/undecided.h"

namespace weft::partition {
namespace {

using meshing::EdgeLists;
using meshing::EdgeTotals;
using meshing::Histogram;
using meshing::Measures;
using meshing::Tet;
using meshing::TetTotals;

using Flags = std::vector<std::uint8_t>;

/// What of a piece is counted of the whole and of the part: entities that no lower subdomain counts too.
struct Counts {
  std::uint64_t vertices = 0, triangles = 0;
};

/// What is summed of a piece. An entity of both whole and part is summed once, for both.
struct PieceMeasures {
  std::span<const Tet> beside, part;  ///< tets of the piece: those of the part apart
  std::vector<Tet> apart;             ///< these, where the part has any
  EdgeLists edges;                    ///< of all of them
  /// Of edges.others, as the next ones: 1 for edges of the part's tets. Empty where it has none here.
  Flags in_part;
  Flags of_whole, of_part;  ///< 1 where no lower subdomain measures the edge too
  Counts whole_counts, part_counts;
};

/// What the pieces' sums are put together of. The sums of one piece come first: doubles, whose order matters.
struct PieceSums {
  std::uint64_t subdomain;
  double volume, complexity, quality, length;
};

bool any_flag(std::span<const std::uint32_t> vertices, const Flags& flags) {
  return std::ranges::any_of(vertices, [&](std::uint32_t v) { return flags[v] != 0; });
}

/// Those of the part behind the others; nothing is copied where it has none.
void divide_tets(const std::vector<Tet>& tets, const Flags& flags, PieceMeasures& piece) {
  const auto in_part = [&](const Tet& tet) { return any_flag(tet, flags); };
  piece.beside = tets;
  if (std::ranges::none_of(flags, [](std::uint8_t flag) { return flag != 0; })) return;
  piece.apart.resize(tets.size());
  const auto end_of_beside =
      std::ranges::copy_if(tets, piece.apart.begin(), [&](const Tet& tet) { return !in_part(tet); }).out;
  std::ranges::copy_if(tets, end_of_beside, in_part);
  const auto beside = static_cast<std::size_t>(end_of_beside - piece.apart.begin());
  piece.beside = std::span(piece.apart).first(beside);
  piece.part = std::span(piece.apart).subspan(beside);
}

/// Marks the edges of the part's tets: all that have a flagged end, and what lies opposite.
void find_edges_of_part(const Flags& flags, PieceMeasures& piece) {
  const EdgeLists& edges = piece.edges;
  if (piece.part.empty()) return;
  piece.in_part.assign(edges.others.size(), 0);
  for (std::size_t v = 0; v < flags.size(); ++v)
    for (std::size_t e = edges.begins[v]; e < edges.begins[v + 1]; ++e)
      piece.in_part[e] = flags[v] | flags[edges.others[e]];
  for (const Tet& tet : piece.part)
    for (const auto& e : meshing::kTetEdges) {
      const auto [a, b] = std::minmax(tet[e[0]], tet[e[1]]);
      if (flags[a] | flags[b]) continue;
      const auto others = edges.of(a);
      piece.in_part[edges.begins[a] +
                    static_cast<std::size_t>(std::ranges::lower_bound(others, b) - others.begin())] = 1;
    }
}

enum MeasuredKind : std::uint64_t { kEdgeOfWhole, kEdgeOfPart, kVertexOfPart };

/// Which edges with two shared ends a lower subdomain measures too is not known here. Who has an edge with a
/// flagged end has it in the part.
void begin_edges(const MeshPiece& mine, const Flags& flags, PieceMeasures& piece, Undecided<2>& undecided) {
  const Flags shared = shared_flags(mine);
  piece.of_whole.assign(piece.edges.others.size(), 1);
  piece.of_part = piece.in_part;
  for (std::size_t v = 0; v < shared.size(); ++v) {
    if (!shared[v]) continue;
    for (std::size_t e = piece.edges.begins[v]; e < piece.edges.begins[v + 1]; ++e) {
      const std::uint32_t w = piece.edges.others[e];
      if (!shared[w]) continue;
      const EntityKey<2> ends = sorted_key<2>({mine.ids[v], mine.ids[w]});
      undecided.add(kEdgeOfWhole, ends, mine.subdomain.value, piece.of_whole[e]);
      if (!piece.part.empty() && piece.in_part[e] && !(flags[v] | flags[w]))
        undecided.add(kEdgeOfPart, ends, mine.subdomain.value, piece.of_part[e]);
    }
  }
}

/// What has been decided of the whole is decided of the part, too.
void end_edges(const Flags& flags, PieceMeasures& piece) {
  for (std::size_t v = 0; v < flags.size() && !piece.part.empty(); ++v)
    for (std::size_t e = piece.edges.begins[v]; e < piece.edges.begins[v + 1]; ++e)
      if (flags[v] | flags[piece.edges.others[e]]) piece.of_part[e] = piece.of_whole[e];
}

/// Marks the vertices of the part's tets, in the lowest subdomain that has them there.
void begin_vertices_of_part(const MeshPiece& mine, const PieceShare& share, const Flags& flags,
                            const PieceMeasures& piece, Flags& counted, Undecided<2>& undecided) {
  counted.assign(flags.size(), 0);
  for (const Tet& tet : piece.part)
    for (const std::uint32_t v : tet) counted[v] = 1;
  const Flags shared = shared_flags(mine);
  for (std::size_t v = 0; v < shared.size(); ++v) {
    if (!counted[v] || !shared[v]) continue;
    if (flags[v])
      counted[v] = share.points[v];
    else
      undecided.add(kVertexOfPart, EntityKey<1>{mine.ids[v]}, mine.subdomain.value, counted[v]);
  }
}

/// What one piece shows by itself.
PieceMeasures look_at(const meshing::MeshData& mesh, const PieceShare& share, const Flags& flags) {
  PieceMeasures piece;
  divide_tets(mesh.tets, flags, piece);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!share.triangles[t]) continue;
    ++piece.whole_counts.triangles;
    piece.part_counts.triangles += any_flag(mesh.triangles[t], flags);
  }
  piece.whole_counts.vertices = static_cast<std::uint64_t>(std::ranges::count(share.points, 1));
  piece.edges = meshing::unique_edges(mesh.tets, mesh.points.size());
  find_edges_of_part(flags, piece);
  return piece;
}

std::vector<PieceMeasures> look_at(Peers& peers, std::span<const MeshPiece> mine, const VertexFlags& flags,
                                   const Numbering* numbering) {
  std::vector<PieceMeasures> pieces(mine.size());
  const std::vector<PieceShare> found = numbering ? std::vector<PieceShare>{} : shares_of(peers, mine);
  std::vector<const PieceShare*> shares;
  for (std::size_t p = 0; p < mine.size(); ++p)
    shares.push_back(numbering ? &numbering->pieces[p].share : &found[p]);
  VertexFlags counted(mine.size());
  std::vector<Undecided<2>> undecided(mine.size());
  meshing::for_each_large(mine.size(), [&](std::size_t p) {
    pieces[p] = look_at(mine[p].mesh, *shares[p], flags[p]);
    begin_vertices_of_part(mine[p], *shares[p], flags[p], pieces[p], counted[p], undecided[p]);
    begin_edges(mine[p], flags[p], pieces[p], undecided[p]);
  });
  Undecided<2>::decide(peers, std::move(undecided));
  meshing::for_each_large(mine.size(), [&](std::size_t p) {
    pieces[p].part_counts.vertices = static_cast<std::uint64_t>(std::ranges::count(counted[p], 1));
    end_edges(flags[p], pieces[p]);
  });
  return pieces;
}

/// Everything that is summed over pieces.
struct Sums {
  Measures counts;  ///< the numbers of entities alone
  TetTotals tets;
  EdgeTotals edges;
  std::vector<PieceSums> pieces;
  std::vector<std::vector<double>> qualities;  ///< of each piece

  void add(SubdomainId subdomain, const TetTotals& of_tets, const EdgeTotals& of_edges,
           const Counts& counted) {
    pieces.push_back({subdomain.value, of_tets.volume, of_tets.complexity, of_tets.quality, of_edges.length});
    tets += of_tets;
    edges += of_edges;
    counts.num_vertices += counted.vertices;
    counts.num_triangles += counted.triangles;
    for (const std::vector<double>& list : qualities) counts.num_tets += list.size();
  }
  /// Those of another piece.
  void add(Sums&& other) {
    pieces.insert(pieces.end(), other.pieces.begin(), other.pieces.end());
    tets += other.tets;
    edges += other.edges;
    counts.num_vertices += other.counts.num_vertices;
    counts.num_triangles += other.counts.num_triangles;
    counts.num_tets += other.counts.num_tets;
    std::ranges::move(other.qualities, std::back_inserter(qualities));
  }
};

struct BothSums {
  Sums whole, part;
};

/// The edges that a function of both flags picks, of the whole and of the part, which has some.
template <class Pick>
Flags picked(const PieceMeasures& piece, const Pick& pick) {
  Flags flags(piece.of_whole.size());
  for (std::size_t e = 0; e < flags.size(); ++e) flags[e] = pick(piece.of_whole[e], piece.of_part[e]);
  return flags;
}

BothSums sums_of(const MeshPiece& piece, const PieceMeasures& look) {
  BothSums sums;
  const meshing::MeasuredPoints points(piece.mesh.points, piece.log_metrics);
  std::vector<double> qualities;
  TetTotals tets = sum_tets(look.beside, points, qualities);
  sums.whole.qualities.push_back(std::move(qualities));
  if (look.part.empty()) {
    sums.whole.add(piece.subdomain, tets, sum_edges(look.edges, look.of_whole, points), look.whole_counts);
    sums.part.add(piece.subdomain, {}, {}, look.part_counts);
    return sums;
  }
  const TetTotals tets_of_part = sum_tets(look.part, points, qualities);
  sums.whole.qualities.push_back(qualities);
  sums.part.qualities.push_back(std::move(qualities));
  tets += tets_of_part;

  const auto edges = [&](const auto& pick) { return sum_edges(look.edges, picked(look, pick), points); };
  EdgeTotals edges_of_whole = edges([](bool whole, bool part) { return whole && !part; });
  EdgeTotals edges_of_part = edges([](bool whole, bool part) { return !whole && part; });
  const EdgeTotals of_both = edges([](bool whole, bool part) { return whole && part; });
  edges_of_whole += of_both;
  edges_of_part += of_both;
  sums.whole.add(piece.subdomain, tets, edges_of_whole, look.whole_counts);
  sums.part.add(piece.subdomain, tets_of_part, edges_of_part, look.part_counts);
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

void add_counts(Peers& peers, BothSums& both) {
  std::vector<std::uint64_t> counts;
  for (Sums* sums : {&both.whole, &both.part})
    for_each_count(*sums, [&](std::uint64_t& count) { counts.push_back(std::exchange(count, 0)); });
  counts = partition::sum(peers, counts);
  std::size_t next = 0;
  for (Sums* sums : {&both.whole, &both.part})
    for_each_count(*sums, [&](std::uint64_t& count) { count = counts[next++]; });
}

void add_extremes(Peers& peers, BothSums& both) {
  std::vector<double> least;
  for (const Sums* sums : {&both.whole, &both.part})
    least.insert(least.end(), {sums->tets.quality_min, sums->edges.length_min, -sums->edges.length_max});
  least = partition::min(peers, least);
  auto next = least.begin();
  for (Sums* sums : {&both.whole, &both.part}) {
    sums->tets.quality_min = *next++;
    sums->edges.length_min = *next++;
    sums->edges.length_max = -*next++;
  }
}

/// By subdomain, so that rounding does not depend on who has which.
void add_reals(Peers& peers, BothSums& both) {
  struct Pair {
    PieceSums whole, part;
  };
  std::vector<Pair> all;
  for (std::size_t p = 0; p < both.whole.pieces.size(); ++p)
    all.push_back({both.whole.pieces[p], both.part.pieces[p]});
  all = allgather_joined(peers, all);
  std::ranges::sort(all, {}, [](const Pair& pair) { return pair.whole.subdomain; });
  const auto add = [](const PieceSums& piece, Sums& sums) {
    sums.tets.volume += piece.volume;
    sums.tets.complexity += piece.complexity;
    sums.tets.quality += piece.quality;
    sums.edges.length += piece.length;
  };
  for (Sums* sums : {&both.whole, &both.part})
    sums->tets.volume = sums->tets.complexity = sums->tets.quality = sums->edges.length = 0;
  for (const Pair& piece : all) {
    add(piece.whole, both.whole);
    add(piece.part, both.part);
  }
}

/// What quantiles are of; none where there are no tets.
struct Quantiles {
  explicit Quantiles(const Sums& sums) : lists(sums.qualities.begin(), sums.qualities.end()) {
    const std::uint64_t n = sums.counts.num_tets;
    if (n > 0) places = {meshing::quantile_place(n, 0.01), meshing::quantile_place(n, 0.001)};
  }
  Selection selection() const { return {lists, places}; }
  std::vector<std::span<const double>> lists;
  std::vector<std::uint64_t> places;
};

Measures measures_of(Sums& sums, const std::vector<double>& quantiles) {
  Measures m = sums.counts;
  if (m.num_tets == 0) return m;
  put_tets(sums.tets, m.num_tets, m);
  put_edges(sums.edges, m);
  m.quality_q01 = quantiles[0];
  m.quality_q001 = quantiles[1];
  return m;
}

WholeAndPart measures_of(Peers& peers, BothSums& both) {
  add_counts(peers, both);
  add_extremes(peers, both);
  add_reals(peers, both);
  const Quantiles of_whole(both.whole), of_part(both.part);
  const std::array<Selection, 2> wanted = {of_whole.selection(), of_part.selection()};
  const std::vector<std::vector<double>> quantiles = select_each(peers, wanted);
  return {measures_of(both.whole, quantiles[0]), measures_of(both.part, quantiles[1])};
}

}  // namespace

Measures measure_pieces(Peers& peers, std::span<const MeshPiece> mine) {
  VertexFlags none;
  for (const MeshPiece& piece : mine) none.emplace_back(piece.mesh.points.size(), 0);
  return measure_pieces(peers, mine, none).whole;
}

WholeAndPart measure_pieces(Peers& peers, std::span<const MeshPiece> mine, const VertexFlags& flags,
                            const Numbering* numbering) {
  std::vector<PieceMeasures> looks = look_at(peers, mine, flags, numbering);
  std::vector<BothSums> of_pieces(mine.size());
  meshing::for_each_large(mine.size(), [&](std::size_t p) {
    of_pieces[p] = sums_of(mine[p], looks[p]);
    looks[p] = {};
  });
  BothSums sums;
  for (BothSums& of_piece : of_pieces) {
    sums.whole.add(std::move(of_piece.whole));
    sums.part.add(std::move(of_piece.part));
  }
  return measures_of(peers, sums);
}

}  // namespace weft::partition
