// Every rank reads ranges of some pieces, whose vertices then get the numbers of the whole mesh.
#include "tools/library/jobs/sources/piece_shares.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/agreement.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/fields/by_components.h"
#include "partition/slice/joined_points.h"

namespace weft::tools {
namespace {

using meshing::PieceRange;
using meshing::SolutionData;
using partition::JoinedPoints;
using partition::Peers;
using partition::Ranges;

/// The common part of two ranges, the first's begin counting as 0.
Share within(std::uint64_t first, std::uint64_t count, Share wanted) {
  const std::uint64_t begin = std::clamp(wanted.first, first, first + count);
  const std::uint64_t end = std::clamp(wanted.first + wanted.count, begin, first + count);
  return {begin - first, end - begin};
}

/// All ranks: what they give, joined in their order.
template <class T>
std::vector<T> joined(Peers& peers, const std::vector<T>& mine) {
  std::vector<T> all;
  for (const auto& of_rank : partition::allgather(peers, mine))
    all.insert(all.end(), of_rank.begin(), of_rank.end());
  return all;
}

/// All ranks: lines of all, in the order of the ranks.
std::vector<std::string> joined_lines(Peers& peers, const std::vector<std::string>& mine) {
  std::vector<char> text;
  for (const std::string& line : mine) text.insert(text.end(), line.c_str(), line.c_str() + line.size() + 1);
  text = joined(peers, text);
  std::vector<std::string> lines;
  for (auto at = text.begin(); at != text.end();) {
    const auto end = std::find(at, text.end(), '\0');
    lines.emplace_back(at, end);
    at = end + 1;
  }
  return lines;
}

/// What of a piece has no place here.
struct PieceDrop {
  std::uint64_t piece;
  Dropped dropped;
};

void append(std::uint64_t piece, const std::vector<Dropped>& dropped, std::vector<PieceDrop>& all) {
  for (const Dropped& d : dropped) all.push_back({piece, d});
}

/// All ranks: what they have dropped, on all.
std::vector<PieceDrop> joined_drops(Peers& peers, const std::vector<PieceDrop>& mine) {
  std::vector<std::string> lines;
  for (const PieceDrop& d : mine)
    lines.insert(lines.end(), {std::to_string(d.piece), d.dropped.what, std::to_string(d.dropped.count)});
  lines = joined_lines(peers, lines);
  std::vector<PieceDrop> all;
  for (std::size_t i = 0; i + 2 < lines.size(); i += 3)
    all.push_back({std::stoull(lines[i]), {lines[i + 1], std::stoull(lines[i + 2])}});
  return all;
}

/// In the order of the pieces, each thing once.
std::vector<Dropped> summed(std::vector<PieceDrop> drops) {
  std::ranges::stable_sort(drops, {}, &PieceDrop::piece);
  meshing::MeshContents sum;
  for (const PieceDrop& d : drops) sum.drop(d.dropped.what, d.dropped.count);
  return sum.dropped;
}

/// Elements by the numbers of copies of their points.
template <std::size_t N>
using Rows = std::vector<std::array<std::uint64_t, N>>;

template <std::size_t N>
void append(const std::vector<std::array<std::uint32_t, N>>& elements, std::uint64_t first_copy,
            Rows<N>& rows) {
  for (const auto& element : elements) {
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < N; ++i) row[i] = first_copy + element[i];
  }
}

template <class T>
void append(const std::vector<T>& values, std::vector<T>& all) {
  all.insert(all.end(), values.begin(), values.end());
}

/// What a rank has read of the pieces.
struct RowsRead {
  Rows<4> tets;
  Rows<3> triangles;
  Rows<2> edges;
  Rows<1> corners;
  std::vector<std::int32_t> tet_refs, triangle_refs, edge_refs;
  std::vector<PieceDrop> drops;
  std::uint64_t foreign_volumes = 0;
  meshing::RefNames names;

  void add(const meshing::MeshContents& piece, std::uint64_t number, std::uint64_t first_copy) {
    append(piece.mesh.tets, first_copy, tets);
    append(piece.mesh.triangles, first_copy, triangles);
    append(piece.mesh.edges, first_copy, edges);
    for (const std::uint32_t corner : piece.mesh.corners) corners.push_back({first_copy + corner});
    append(piece.mesh.tet_refs, tet_refs);
    append(piece.mesh.triangle_refs, triangle_refs);
    append(piece.mesh.edge_refs, edge_refs);
    append(number, piece.dropped, drops);
    foreign_volumes += piece.foreign_volumes;
  }
};

/// Gives elements the numbers of the whole mesh.
class Renumbering {
 public:
  /// All ranks.
  Renumbering(Peers& peers, const JoinedPoints& points, const RowsRead& rows) {
    add(rows.tets), add(rows.triangles), add(rows.edges), add(rows.corners);
    meshing::sort_unique(copies_);
    numbers_ = points.numbers_of(peers, copies_);
  }
  template <std::size_t N>
  std::vector<std::array<std::uint32_t, N>> of(const Rows<N>& rows) const {
    std::vector<std::array<std::uint32_t, N>> elements(rows.size());
    for (std::size_t e = 0; e < rows.size(); ++e)
      for (std::size_t i = 0; i < N; ++i) elements[e][i] = numbers_[meshing::place_in(copies_, rows[e][i])];
    return elements;
  }

 private:
  template <std::size_t N>
  void add(const Rows<N>& rows) {
    for (const auto& row : rows) copies_.insert(copies_.end(), row.begin(), row.end());
  }

  std::vector<std::uint64_t> copies_;  ///< that elements use
  std::vector<std::uint32_t> numbers_;
};

/// All ranks: a share of the triangles, edges and corners of all.
void take_boundary(Peers& peers, const RowsRead& rows, const Renumbering& numbers, const Ranges& points,
                   partition::MeshSlice& slice) {
  meshing::MeshData& boundary = slice.boundary;
  boundary.triangles = dealt_evenly(peers, numbers.of(rows.triangles));
  boundary.triangle_refs = dealt_evenly(peers, rows.triangle_refs);
  boundary.edges = dealt_evenly(peers, numbers.of(rows.edges));
  boundary.edge_refs = dealt_evenly(peers, rows.edge_refs);
  std::vector<std::uint32_t> corners;
  for (const auto& corner : numbers.of(rows.corners)) corners.push_back(corner[0]);
  boundary.corners = partition::each_at_its_point(peers, points, corners);
  count_boundary(peers, slice);
}

/// A field of a piece, as one of its readers knows it.
struct FieldHead {
  std::uint64_t piece, index;  ///< among the piece's fields
  Field::Kind kind;
  bool fits;  ///< has a place here, as far as the reader's values show
  std::string name;
};

/// All ranks: the heads of all, by piece and index; one field each, which fits where it does for all readers.
std::vector<FieldHead> joined_heads(Peers& peers, const std::vector<FieldHead>& mine) {
  std::vector<std::string> lines;
  for (const FieldHead& h : mine)
    lines.insert(lines.end(), {std::to_string(h.piece), std::to_string(h.index),
                               std::to_string(static_cast<int>(h.kind)), h.fits ? "1" : "0", h.name});
  lines = joined_lines(peers, lines);
  std::vector<FieldHead> all;
  for (std::size_t i = 0; i + 4 < lines.size(); i += 5)
    all.push_back({std::stoull(lines[i]), std::stoull(lines[i + 1]),
                   static_cast<Field::Kind>(std::stoi(lines[i + 2])), lines[i + 3] == "1", lines[i + 4]});
  std::ranges::stable_sort(all, {}, [](const FieldHead& h) { return std::pair(h.piece, h.index); });
  std::vector<FieldHead> heads;
  for (FieldHead& h : all) {
    if (!heads.empty() && heads.back().piece == h.piece && heads.back().index == h.index) {
      heads.back().fits = heads.back().fits && h.fits;
    } else {
      heads.push_back(std::move(h));
    }
  }
  return heads;
}

/// The fields that all pieces have, as meshing::merge_pieces() matches them.
class CommonFields {
 public:
  CommonFields(const std::vector<FieldHead>& heads, std::uint64_t num_pieces) {
    for (const FieldHead& head : heads) {
      if (head.fits) {
        match(head);
      } else {
        drops_.push_back({head.piece, {meshing::kSkewTensors, 1}});
      }
    }
    for (Known& known : known_) {
      known.is_common = known.in_pieces == num_pieces;
      if (known.is_common) {
        known.place = kinds_.fields.size();
        kinds_.fields.push_back({known.head.kind, {}, known.head.name});
      } else {
        drops_.push_back({num_pieces, {"fields that some pieces lack", 1}});
      }
    }
  }

  /// Kinds and names.
  const SolutionData& kinds() const { return kinds_; }
  const std::vector<PieceDrop>& drops() const { return drops_; }
  /// Which of a piece's fields is field `f`.
  std::size_t index_in(std::uint64_t piece, std::size_t f) const {
    const auto found = std::ranges::find_if(matches_, [&](const Match& m) {
      return m.piece == piece && known_[m.known].is_common && known_[m.known].place == f;
    });
    return found->index;
  }

 private:
  struct Known {
    FieldHead head;
    std::uint64_t in_pieces = 0;  ///< as long as no piece has lacked it
    bool is_common = false;
    std::size_t place = 0;
  };
  struct Match {
    std::uint64_t piece;
    std::size_t index, known;
  };

  void match(const FieldHead& head) {
    auto known = std::ranges::find_if(known_, [&](const Known& k) {
      return k.head.name == head.name && k.head.kind == head.kind && k.in_pieces == head.piece;
    });
    if (known == known_.end()) {
      known_.push_back({head});
      known = known_.end() - 1;
    }
    matches_.push_back({head.piece, head.index, static_cast<std::size_t>(known - known_.begin())});
    if (known->in_pieces == head.piece) ++known->in_pieces;
  }

  std::vector<Known> known_;
  std::vector<Match> matches_;
  SolutionData kinds_;
  std::vector<PieceDrop> drops_;
};

}  // namespace

/// This rank's points of the pieces, and what they are in the whole mesh.
struct PieceShares::Copies {
  std::vector<meshing::Point> points;
  std::vector<std::int32_t> refs;
  JoinedPoints joined;
};

PieceShares::PieceShares(Peers& peers, const std::string& file) : file_(file) {
  struct Row {
    std::uint64_t source, points, tets, has_ids, not_refs;
  };
  std::vector<Row> mine;
  partition::agree_on(peers, [&] { sources_ = meshing::piece_sources(file); });
  partition::agree_on(peers, [&] {
    const Share share = share_of(sources_.size(), peers.rank(), peers.ranks());
    for (std::uint64_t s = share.first; s < share.first + share.count; ++s)
      for (const meshing::PieceSize& size : meshing::piece_sizes(sources_[s]))
        mine.push_back({s, size.points, size.tets, size.has_ids, size.not_refs});
  });
  for (const Row& row : joined(peers, mine)) {
    pieces_.push_back({row.source, {row.points, row.tets}, num_points_, num_tets_});
    num_points_ += row.points;
    num_tets_ += row.tets;
    by_ids_ = by_ids_ && row.has_ids;
    not_refs_ |= static_cast<std::uint8_t>(row.not_refs);
  }
}

/// Of each piece the part that these shares have.
std::vector<PieceRange> PieceShares::ranges(Share points, Share tets, Share others) const {
  std::vector<PieceRange> ranges;
  for (const Piece& piece : pieces_) {
    const Share p = within(piece.first_point, piece.size.points, points);
    const Share t = within(piece.first_tet, piece.size.tets, tets);
    const bool is_mine = ranges.size() - others.first < others.count;
    ranges.push_back({{p.first, p.count, t.first, t.count}, is_mine, not_refs_});
  }
  return ranges;
}

/// read(source, the ranges of its pieces, the first of these) for each file of which anything is wanted, or
/// all.
template <class Read>
void PieceShares::read_sources(const std::vector<PieceRange>& ranges, bool always, const Read& read) const {
  for (std::size_t begin = 0, end = 0; begin < pieces_.size(); begin = end) {
    while (end < pieces_.size() && pieces_[end].source == pieces_[begin].source) ++end;
    const std::span<const PieceRange> of_source(ranges.data() + begin, end - begin);
    if (always || !std::ranges::all_of(of_source, meshing::is_empty))
      read(sources_[pieces_[begin].source], of_source, begin);
  }
}

MeshShare PieceShares::mesh(Peers& peers, meshing::OtherVolumes others) const {
  const int rank = peers.rank(), num_ranks = peers.ranks();
  const Share my_tets = share_of(num_tets_, rank, num_ranks);
  const auto wanted = ranges({0, 0}, my_tets, share_of(pieces_.size(), rank, num_ranks));
  RowsRead rows;
  partition::agree_on(peers, [&] {
    // Rank 0 is to have the names, which only files with all pieces in them may have.
    read_sources(wanted, rank == 0 && sources_.size() == 1,
                 [&](const auto& source, auto of_source, std::size_t first) {
                   meshing::PieceRanges read = meshing::read_piece_ranges(source, of_source);
                   rows.names = std::move(read.names);
                   for (std::size_t i = 0; i < read.pieces.size(); ++i) {
                     rows.add(read.pieces[i].contents, first + i, pieces_[first + i].first_point);
                     read.pieces[i] = {};
                   }
                 });
  });
  const std::uint64_t other_volumes = partition::sum(peers, rows.foreign_volumes);
  if (others == meshing::OtherVolumes::refused) meshing::refuse_foreign_volumes(other_volumes, file_);

  const Copies copies = read_points(peers);
  MeshShare share;
  partition::MeshSlice& slice = share.slice;
  slice.num_points = copies.joined.total();
  slice.num_tets = num_tets_;
  slice.first_tet = my_tets.first;
  const Share my_points = share_of(slice.num_points, rank, num_ranks);
  slice.first_point = my_points.first;
  const Ranges points(peers, my_points.count);
  slice.points = copies.joined.deal(peers, copies.points, JoinedPoints::Copy::first, points);
  slice.point_refs = copies.joined.deal(peers, copies.refs, JoinedPoints::Copy::last, points);
  const Renumbering numbers(peers, copies.joined, rows);
  slice.tets = numbers.of(rows.tets);
  slice.tet_refs = std::move(rows.tet_refs);
  take_boundary(peers, rows, numbers, points, slice);
  share.names = std::move(rows.names);
  share.dropped = summed(joined_drops(peers, rows.drops));
  return share;
}

FieldsShare PieceShares::fields(Peers& peers) const {
  const auto wanted = ranges(share_of(num_points_, peers.rank(), peers.ranks()), {0, 0},
                             share_of(pieces_.size(), peers.rank(), peers.ranks()));
  std::vector<std::pair<std::uint64_t, SolutionData>> read_here;
  std::vector<FieldHead> heads;
  std::vector<PieceDrop> drops;
  partition::agree_on(peers, [&] {
    read_sources(wanted, false, [&](const auto& source, auto of_source, std::size_t first) {
      std::vector<meshing::MeshContents> read = meshing::read_piece_fields(source, of_source);
      for (std::size_t i = 0; i < read.size(); ++i) {
        if (meshing::is_empty(of_source[i])) continue;
        SolutionData& fields = read[i].fields;
        append(first + i, read[i].dropped, drops);
        for (std::size_t f = 0; f < fields.fields.size(); ++f) {
          const Field& field = fields.fields[f];
          const bool fits = of_source[i].rows.num_points == 0 || !field.values.empty();
          heads.push_back({first + i, f, field.kind, fits, field.name});
        }
        read_here.emplace_back(first + i, std::move(fields));
      }
    });
  });
  const CommonFields common(joined_heads(peers, heads), pieces_.size());
  drops = joined_drops(peers, drops);
  append(common.drops(), drops);

  const JoinedPoints joined_points = read_points(peers).joined;
  const Share my_points = share_of(joined_points.total(), peers.rank(), peers.ranks());
  const Ranges points(peers, my_points.count);
  SolutionData of_copies = common.kinds();
  for (std::size_t f = 0; f < of_copies.fields.size(); ++f)
    for (const auto& [piece, fields] : read_here)
      if (fields.num_points > 0)
        append(fields.fields[common.index_in(piece, f)].values, of_copies.fields[f].values);
  return {partition::by_components(of_copies, my_points.count,
                                   [&](const std::vector<double>& column) {
                                     return joined_points.deal(peers, column, JoinedPoints::Copy::last,
                                                               points);
                                   }),
          joined_points.total(), summed(std::move(drops))};
}

PieceShares::Copies PieceShares::read_points(Peers& peers) const {
  const auto wanted = ranges(share_of(num_points_, peers.rank(), peers.ranks()), {0, 0}, {0, 0});
  std::vector<meshing::Point> points;
  std::vector<std::int32_t> refs;
  std::vector<std::int64_t> ids;
  partition::agree_on(peers, [&] {
    read_sources(wanted, false, [&](const auto& source, auto of_source, std::size_t) {
      for (const meshing::MeshPiece& piece : meshing::read_piece_ranges(source, of_source).pieces) {
        append(piece.contents.mesh.points, points);
        append(piece.contents.mesh.point_refs, refs);
        if (by_ids_) append(piece.global_ids, ids);
      }
    });
  });
  const bool is_joined = pieces_.size() > 1;
  if (is_joined && !by_ids_)
    for (meshing::Point& p : points)
      for (int c = 0; c < 3; ++c) p[c] += 0.0;  // turns -0 into 0, as the merged mesh has it
  JoinedPoints joined_points =
      is_joined ? JoinedPoints(peers, points, ids, by_ids_) : JoinedPoints(peers, points.size());
  return {std::move(points), std::move(refs), std::move(joined_points)};
}

}  // namespace weft::tools
