// Rows of pieces go to the ranks whose slices have them, and values come back.
#include "partition/fields/piece_slices.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/even_shares.h"
#include "partition/communication/point_limit.h"
#include "partition/communication/ranges.h"
#include "partition/fields/by_components.h"
#include "partition/output/own_entities.h"

namespace weft::partition {
namespace {

/// Rows, of which runs are numbered one after the other, to the ranks that have these numbers.
template <class Row>
class RowMail {
 public:
  RowMail(Peers& peers, std::uint64_t total)
      : peers_(peers),
        shares_(total, peers.ranks()),
        runs_(static_cast<std::size_t>(peers.ranks())),
        rows_(runs_.size()) {}

  template <class Rows, class Convert>
  void add(std::uint64_t first, const Rows& rows, const Convert& convert) {
    std::size_t begin = 0;
    for (std::uint64_t rank = 0; begin < rows.size(); ++rank) {
      const std::uint64_t last = shares_.first(rank + 1);
      if (last <= first + begin) continue;
      const std::size_t end = std::min<std::uint64_t>(rows.size(), last - first);
      runs_[rank].push_back({first + begin, end - begin});
      for (; begin < end; ++begin) rows_[rank].push_back(convert(rows[begin]));
    }
  }
  std::vector<Row> deliver() {
    const int me = peers_.rank();
    const std::uint64_t first = shares_.first(me);
    const auto runs = partition::all_to_all(peers_, std::move(runs_));
    const auto rows = partition::all_to_all(peers_, std::move(rows_));
    std::vector<Row> mine(shares_.count(me));
    for (std::size_t r = 0; r < runs.size(); ++r) {
      auto row = rows[r].begin();
      for (const Run& run : runs[r]) {
        std::copy_n(row, run.count, mine.begin() + static_cast<std::ptrdiff_t>(run.first - first));
        row += static_cast<std::ptrdiff_t>(run.count);
      }
    }
    return mine;
  }

 private:
  struct Run {
    std::uint64_t first, count;
  };

  Peers& peers_;
  EvenShares shares_;
  std::vector<std::vector<Run>> runs_;
  std::vector<std::vector<Row>> rows_;
};

}  // namespace

MeshSlice slice_of_pieces(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering) {
  const std::uint64_t points = numbering.totals.points, tets = numbering.totals.tets;
  refuse_too_many_points(points);
  RowMail<meshing::Point> point_mail(peers, points);
  RowMail<meshing::Tet> tet_mail(peers, tets);
  for (std::size_t p = 0; p < mine.size(); ++p) {
    const OwnEntities own = own_entities(mine[p], numbering.pieces[p]);
    point_mail.add(numbering.pieces[p].first.points, own.points, [](const meshing::Point& x) { return x; });
    const std::vector<std::uint64_t>& numbers = numbering.pieces[p].points;
    tet_mail.add(numbering.pieces[p].first.tets, mine[p].mesh.tets, [&](meshing::Tet tet) {
      for (std::uint32_t& v : tet) v = static_cast<std::uint32_t>(numbers[v]);
      return tet;
    });
  }
  MeshSlice slice;
  slice.num_points = points;
  slice.num_tets = tets;
  slice.first_point = EvenShares(points, peers.ranks()).first(peers.rank());
  slice.first_tet = EvenShares(tets, peers.ranks()).first(peers.rank());
  slice.points = point_mail.deliver();
  slice.point_refs.resize(slice.points.size());
  slice.tets = tet_mail.deliver();
  slice.tet_refs.resize(slice.tets.size());
  return slice;
}

PieceFields fields_of_pieces(Peers& peers, const MeshSlice& slice, const Numbering& numbering,
                             const meshing::SolutionData& of_slice) {
  std::vector<std::uint64_t> numbers;
  for (const PieceNumbers& piece : numbering.pieces)
    numbers.insert(numbers.end(), piece.points.begin(), piece.points.end());
  std::ranges::sort(numbers);
  const auto rest = std::ranges::unique(numbers);
  numbers.erase(rest.begin(), rest.end());
  const Ranges points(peers, slice.points.size());
  const meshing::SolutionData here = by_components(of_slice, numbers.size(), [&](const auto& column) {
    return fetch<double>(peers, points, numbers, [&](std::size_t i) { return column[i]; });
  });
  PieceFields result;
  for (const meshing::Field& field : here.fields) result.kinds.fields.push_back({field.kind, {}, field.name});
  for (const PieceNumbers& piece : numbering.pieces)
    result.of_pieces.push_back(by_components(here, piece.points.size(), [&](const auto& column) {
      std::vector<double> values;
      for (const std::uint64_t number : piece.points)
        values.push_back(column[meshing::place_in(numbers, number)]);
      return values;
    }));
  return result;
}

}  // namespace weft::partition
