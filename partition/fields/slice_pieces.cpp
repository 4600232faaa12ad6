// What a piece has follows from numbers: it is fetched from the ranks that have it.
#include "partition/fields/slice_pieces.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/base/release.h"
#include "meshing/base/sort_unique.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/vtk/pvtu.h"
#include "meshing/io/vtk/vtu.h"
#include "partition/communication/agreement.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/fields/by_components.h"

namespace weft::partition {
namespace {

namespace fs = std::filesystem;
using meshing::MeshData;

template <std::size_t N>
struct ElementRow {
  std::array<std::uint32_t, N> vertices;
  std::int32_t ref;
};
struct PointRow {
  meshing::Point place;
  std::int64_t ref;
};

/// Puts pieces together, one a rank at a time.
class PieceMaker {
 public:
  /// All ranks.
  PieceMaker(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
             std::size_t num_pieces)
      : peers_(peers),
        slice_(slice),
        fields_(fields),
        num_pieces_(num_pieces),
        points_(peers, slice.points.size()),
        tets_(peers, slice.tets.size()),
        triangles_(peers, slice.boundary.triangles.size()),
        edges_(peers, slice.boundary.edges.size()),
        corners_(peers, slice.boundary.corners.size()),
        first_points_(points_of_no_element()) {}

  /// All ranks: this one's piece; num_pieces: none.
  meshing::MeshContents make(std::size_t piece) {
    piece_ = piece;
    meshing::MeshContents contents;
    MeshData& mesh = contents.mesh;
    const MeshData& b = slice_.boundary;
    fetch_elements(tets_, slice_.tets, slice_.tet_refs, mesh.tets, mesh.tet_refs);
    fetch_elements(triangles_, b.triangles, b.triangle_refs, mesh.triangles, mesh.triangle_refs);
    fetch_elements(edges_, b.edges, b.edge_refs, mesh.edges, mesh.edge_refs);
    mesh.corners =
        fetch<std::uint32_t>(peers_, corners_, wanted(corners_), [&](std::size_t i) { return b.corners[i]; });
    number(mesh);
    fetch_points(contents);
    return contents;
  }
  /// Numbers in the whole mesh of the points of the last piece made.
  const std::vector<std::int64_t>& global_ids() const { return ids_; }

 private:
  std::size_t begin(std::size_t n) const { return piece_ == num_pieces_ ? n : n * piece_ / num_pieces_; }
  std::size_t end(std::size_t n) const { return piece_ == num_pieces_ ? n : n * (piece_ + 1) / num_pieces_; }

  /// All ranks: with which the first piece begins, on rank 0, which makes it: all where it is the only one.
  std::vector<std::uint32_t> points_of_no_element() {
    std::vector<std::uint32_t> used;
    if (num_pieces_ > 1) {
      const auto add = [&](const auto& elements) {
        for (const auto& element : elements) used.insert(used.end(), element.begin(), element.end());
      };
      add(slice_.tets);
      add(slice_.boundary.triangles);
      add(slice_.boundary.edges);
    }
    meshing::sort_unique(used);
    std::vector<std::vector<std::uint32_t>> to_owners(static_cast<std::size_t>(peers_.ranks()));
    for (const std::uint32_t v : used) to_owners[points_.rank_of(v)].push_back(v);
    meshing::release(used);
    const auto first = static_cast<std::uint32_t>(slice_.first_point);
    std::vector<std::uint8_t> is_used(slice_.points.size(), 0);
    for (const auto& of_rank : partition::all_to_all(peers_, std::move(to_owners)))
      for (const std::uint32_t v : of_rank) is_used[v - first] = 1;
    std::vector<std::vector<std::uint32_t>> to_first(static_cast<std::size_t>(peers_.ranks()));
    for (std::uint32_t i = 0; i < is_used.size(); ++i)
      if (!is_used[i]) to_first[0].push_back(first + i);
    return all_to_all_joined(peers_, std::move(to_first));
  }

  /// The numbers of the piece's part.
  std::vector<std::uint64_t> wanted(const Ranges& ranges) const {
    std::vector<std::uint64_t> numbers(end(ranges.total()) - begin(ranges.total()));
    std::iota(numbers.begin(), numbers.end(), begin(ranges.total()));
    return numbers;
  }

  /// All ranks: the piece's part of elements that ranks have in `ranges`, here `from`.
  template <std::size_t N>
  void fetch_elements(const Ranges& ranges, const std::vector<std::array<std::uint32_t, N>>& from,
                      const std::vector<std::int32_t>& from_refs,
                      std::vector<std::array<std::uint32_t, N>>& to, std::vector<std::int32_t>& to_refs) {
    using Row = ElementRow<N>;
    const auto row_of = [&](std::size_t i) { return Row{from[i], from_refs[i]}; };
    for (const Row& row : fetch<Row>(peers_, ranges, wanted(ranges), row_of)) {
      to.push_back(row.vertices);
      to_refs.push_back(row.ref);
    }
  }

  /// Points in the order in which they are first used.
  void number(MeshData& mesh) {
    std::vector<std::uint32_t> uses;
    if (piece_ == 0) uses = first_points_;
    const auto for_each_vertex = [&](const auto& action) {
      for (auto& tet : mesh.tets) std::ranges::for_each(tet, action);
      for (auto& triangle : mesh.triangles) std::ranges::for_each(triangle, action);
      for (auto& edge : mesh.edges) std::ranges::for_each(edge, action);
      std::ranges::for_each(mesh.corners, action);
    };
    for_each_vertex([&](std::uint32_t& v) { uses.push_back(v); });
    sorted_ = uses;
    meshing::sort_unique(sorted_);
    ids_.clear();
    std::vector<std::uint32_t> numbers(sorted_.size(), kUnused);
    for (const std::uint32_t v : uses) {
      std::uint32_t& number = numbers[meshing::place_in(sorted_, v)];
      if (number != kUnused) continue;
      number = static_cast<std::uint32_t>(ids_.size());
      ids_.push_back(v);
    }
    for_each_vertex([&](std::uint32_t& v) { v = numbers[meshing::place_in(sorted_, v)]; });
  }

  void fetch_points(meshing::MeshContents& contents) {
    const auto rows = fetch<PointRow>(peers_, points_, sorted_, [&](std::size_t i) {
      return PointRow{slice_.points[i], slice_.point_refs[i]};
    });
    for (const std::int64_t id : ids_) {
      const PointRow& row = rows[meshing::place_in(sorted_, static_cast<std::uint32_t>(id))];
      contents.mesh.points.push_back(row.place);
      contents.mesh.point_refs.push_back(static_cast<std::int32_t>(row.ref));
    }
    contents.fields = by_components(fields_, ids_.size(), [&](const std::vector<double>& column) {
      const auto values = fetch<double>(peers_, points_, sorted_, [&](std::size_t i) { return column[i]; });
      std::vector<double> of_piece;
      for (const std::int64_t id : ids_)
        of_piece.push_back(values[meshing::place_in(sorted_, static_cast<std::uint32_t>(id))]);
      return of_piece;
    });
  }

  static constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

  Peers& peers_;
  const MeshSlice& slice_;
  const meshing::SolutionData& fields_;
  std::size_t num_pieces_;
  Ranges points_, tets_, triangles_, edges_, corners_;
  std::vector<std::uint32_t> first_points_;
  // Of the piece being made:
  std::size_t piece_ = 0;
  std::vector<std::uint32_t> sorted_;  ///< its points
  std::vector<std::int64_t> ids_;      ///< in the order of the piece
};

}  // namespace

void write_slices_as_pvtu(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                          const fs::path& file, const meshing::WriteOptions& options) {
  const auto num_pieces = static_cast<std::size_t>(std::max(1, options.pieces));
  const auto ranks = static_cast<std::size_t>(peers.ranks());
  std::vector<std::string> names;
  std::vector<std::size_t> mine;
  for (std::size_t p = 0; p < num_pieces; ++p) {
    names.push_back(file.stem().string() + "_" + std::to_string(p) + ".vtu");
    if (p * ranks / num_pieces == static_cast<std::size_t>(peers.rank())) mine.push_back(p);
  }
  PieceMaker maker(peers, slice, fields, num_pieces);
  const bool point_refs = partition::max(peers, std::uint8_t{meshing::has_refs(slice.point_refs)}) != 0;
  std::list<meshing::FormerFile> former;  // what was there comes back when anybody fails
  const std::size_t rounds = partition::max(peers, mine.size());
  for (std::size_t round = 0; round < rounds; ++round) {
    const std::size_t piece = round < mine.size() ? mine[round] : num_pieces;
    const meshing::MeshContents contents = maker.make(piece);
    agree_on(peers, [&] {
      if (piece == num_pieces) return;
      const fs::path path = file.parent_path() / names[piece];
      former.emplace_back(path);
      meshing::write_vtu_piece(path, contents, maker.global_ids(), point_refs, options);
    });
  }
  agree_on(peers, [&] {
    if (peers.rank() == 0) meshing::write_pvtu_index(file, fields, point_refs, {}, names);
  });
}

}  // namespace weft::partition
