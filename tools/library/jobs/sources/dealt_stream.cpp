// Rank 0 says before each block what comes and for whom; the others listen until it says that nothing more
// does.
#include "tools/library/jobs/sources/dealt_stream.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/base/release.h"
#include "meshing/io/mesh_file.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/agreement.h"
#include "partition/communication/even_shares.h"
#include "partition/communication/reduce.h"

namespace weft::tools {
namespace {

using meshing::Point;
using meshing::Tet;
using partition::Peers;

/// Arrays of a mesh: those of the boundary follow in the order of for_each_boundary_array().
enum class Column : std::uint64_t { none, points, point_refs, tets, tet_refs, other_tet_refs, boundary };
constexpr std::size_t kColumns = static_cast<std::size_t>(Column::boundary) + meshing::kBoundaryArrays;

constexpr std::size_t index_of(Column column) { return static_cast<std::size_t>(column); }
constexpr Column column_of_boundary(std::size_t array) {
  return static_cast<Column>(index_of(Column::boundary) + array);
}

/// What rank 0 says before a block. Without padding.
struct Announcement {
  Column column;
  std::uint64_t first;  ///< number of the first row in the whole mesh
  std::uint64_t rank;   ///< whose the block is
};

/// Rows of one array, of which this rank has some blocks.
class DealtColumn {
 public:
  void add(std::uint64_t first, partition::Bytes rows) { blocks_.push_back({first, std::move(rows)}); }

  /// All ranks: the rows that this rank is to have; zeros where no rank has any. What was dealt is given up.
  template <class T>
  std::vector<T> share(Peers& peers, std::uint64_t total) {
    std::vector<std::vector<std::uint64_t>> runs(static_cast<std::size_t>(peers.ranks()));  // first, count
    std::vector<std::vector<T>> rows(runs.size());
    for (Block& block : blocks_) {
      const std::vector<T> of_block = partition::values_of<T>(std::exchange(block.rows, {}));
      for (int r = 0; r < peers.ranks(); ++r) {
        const Share s = share_of(total, r, peers.ranks());
        const std::uint64_t end = block.first + of_block.size();
        const std::uint64_t from = std::clamp(s.first, block.first, end);
        const std::uint64_t to = std::clamp(s.first + s.count, from, end);
        if (from == to) continue;
        auto& of_rank = rows[static_cast<std::size_t>(r)];
        runs[static_cast<std::size_t>(r)].insert(runs[static_cast<std::size_t>(r)].end(), {from, to - from});
        of_rank.insert(of_rank.end(), of_block.begin() + static_cast<std::ptrdiff_t>(from - block.first),
                       of_block.begin() + static_cast<std::ptrdiff_t>(to - block.first));
      }
    }
    blocks_ = {};
    const auto runs_here = partition::all_to_all(peers, std::move(runs));
    auto rows_here = partition::all_to_all(peers, std::move(rows));
    const Share mine = share_of(total, peers.rank(), peers.ranks());
    std::vector<T> share(mine.count);
    for (std::size_t r = 0; r < runs_here.size(); ++r) {
      auto next = rows_here[r].begin();
      for (std::size_t i = 0; i < runs_here[r].size(); i += 2) {
        const auto end = next + static_cast<std::ptrdiff_t>(runs_here[r][i + 1]);
        std::copy(next, end, share.begin() + static_cast<std::ptrdiff_t>(runs_here[r][i] - mine.first));
        next = end;
      }
      meshing::release(rows_here[r]);
    }
    return share;
  }

 private:
  struct Block {
    std::uint64_t first;
    partition::Bytes rows;
  };
  std::vector<Block> blocks_;
};

/// What all ranks have to know of what rank 0 has read. Plain data.
struct Counts {
  std::array<std::uint64_t, kColumns> rows{};
  std::array<std::uint64_t, 4> prefers_other{};  ///< MeshStream::prefer_other_refs(), by dimension
  std::uint64_t of(Column column) const { return rows[index_of(column)]; }
};

/// What this rank has got of the mesh so far, by column.
using DealtArrays = std::array<DealtColumn, kColumns>;

/// All ranks: one block from rank 0, which alone knows what comes. Returns whether any has come.
bool pass_block(Peers& peers, const Announcement& mine, partition::Bytes rows, DealtArrays& arrays) {
  std::vector<partition::Bytes> to_each(static_cast<std::size_t>(peers.ranks()));
  if (peers.rank() == 0)
    for (std::size_t r = 0; r < to_each.size(); ++r) {
      to_each[r] = partition::bytes_of(std::vector{mine});
      if (r == mine.rank) to_each[r].insert(to_each[r].end(), rows.begin(), rows.end());
    }
  meshing::release(rows);
  partition::Bytes arrived = std::move(peers.all_to_all(std::move(to_each))[0]);
  const Announcement said =
      partition::values_of<Announcement>({arrived.begin(), arrived.begin() + sizeof(Announcement)})[0];
  if (said.rank == static_cast<std::uint64_t>(peers.rank())) {
    arrived.erase(arrived.begin(), arrived.begin() + sizeof(Announcement));
    arrays[index_of(said.column)].add(said.first, std::move(arrived));
  }
  return said.column != Column::none;
}

/// Of rank 0: the reader's rows go on to the ranks in turn.
class Dealer final : public meshing::MeshStream {
 public:
  Dealer(Peers& peers, DealtArrays& arrays) : peers_(peers), arrays_(arrays) {}

  void take_points(std::vector<Point> rows) override { deal(Column::points, rows); }
  void take_point_refs(std::vector<std::int32_t> rows) override { deal(Column::point_refs, rows); }
  void take_tets(std::vector<Tet> rows) override { deal(Column::tets, rows); }
  void take_tet_refs(std::vector<std::int32_t> rows) override { deal(Column::tet_refs, rows); }
  void take_other_tet_refs(std::vector<std::int32_t> rows) override { deal(Column::other_tet_refs, rows); }
  void take_boundary(meshing::BoundaryRows rows) override {
    std::size_t array = 0;
    meshing::for_each_boundary_array([&](auto of_rows) { deal(column_of_boundary(array++), of_rows(rows)); });
  }
  void prefer_other_refs(int dimension) override {
    counts_.prefers_other[static_cast<std::size_t>(dimension)] = 1;
  }
  void set_point_ref(std::uint32_t point, std::int32_t ref) override {
    refs_of_points_.emplace_back(point, ref);
  }

  /// The others stop listening.
  void end() { pass_block(peers_, {Column::none, 0, 0}, {}, arrays_); }

  const Counts& counts() const { return counts_; }
  const std::vector<std::pair<std::uint32_t, std::int32_t>>& refs_of_points() const {
    return refs_of_points_;
  }

 private:
  template <class T>
  void deal(Column column, const std::vector<T>& rows) {
    if (rows.empty()) return;
    std::uint64_t& count = counts_.rows[index_of(column)];
    const std::uint64_t rank = count / kRows % static_cast<std::uint64_t>(peers_.ranks());
    pass_block(peers_, {column, count, rank}, partition::bytes_of(rows), arrays_);
    count += rows.size();
  }

  Peers& peers_;
  DealtArrays& arrays_;
  Counts counts_;
  std::vector<std::pair<std::uint32_t, std::int32_t>> refs_of_points_;
};

/// The points with a reference of their own, after the arrays.
void set_point_refs(Peers& peers, const std::vector<std::pair<std::uint32_t, std::int32_t>>& refs,
                    partition::MeshSlice& slice) {
  std::vector<std::uint32_t> points;
  std::vector<std::int32_t> values;
  for (const auto& [point, ref] : refs) points.push_back(point), values.push_back(ref);
  points = partition::allgather(peers, points)[0];
  values = partition::allgather(peers, values)[0];
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i] >= slice.first_point && points[i] - slice.first_point < slice.points.size())
      slice.point_refs[points[i] - slice.first_point] = values[i];
}

/// All ranks: this one's share of triangles, edges and marks, beside what is in the slice already.
void add_boundary(Peers& peers, const Counts& counts, DealtArrays& arrays, partition::MeshSlice& slice) {
  meshing::BoundaryRows shares;
  std::size_t array = 0;
  meshing::for_each_boundary_array([&](auto of_rows) {
    auto& rows = of_rows(shares);
    const Column column = column_of_boundary(array++);
    using Row = typename std::decay_t<decltype(rows)>::value_type;
    if (counts.of(column) > 0) rows = arrays[index_of(column)].share<Row>(peers, counts.of(column));
  });
  meshing::MeshCollector all;
  all.take_boundary(std::move(shares));
  for (const int dimension : {1, 2})
    if (counts.prefers_other[static_cast<std::size_t>(dimension)] != 0) all.prefer_other_refs(dimension);
  all.put_into(slice.boundary);
  slice.boundary.triangle_refs.resize(slice.boundary.triangles.size());
  slice.boundary.edge_refs.resize(slice.boundary.edges.size());
  count_boundary(peers, slice);
}

/// What rank 0 says of fields. Without padding.
struct FieldNews {
  enum class Kind : std::uint64_t { begin, rows, end, drop, none } kind;
  std::uint64_t length, points;  ///< of one that begins
};

/// Of all ranks. The reader's calls are those of rank 0; the others listen().
class DealtFields final : public meshing::FieldStream {
 public:
  explicit DealtFields(Peers& peers) : peers_(peers) {}

  void begin(const std::string& name, std::uint64_t length, std::uint64_t points) override {
    exchange(news({FieldNews::Kind::begin, length, points}, name));
  }
  void take(std::vector<std::uint32_t> points, std::vector<double> values) override {
    std::vector<partition::Bytes> to_each = news({FieldNews::Kind::rows, 0, 0});
    const std::uint64_t length = field_->length();
    const partition::EvenShares shares = this->shares();
    for (const std::uint32_t p : points) partition::append(to_each[shares.rank_of(p)], &p, sizeof p);
    for (std::size_t i = 0; i < points.size(); ++i)
      partition::append(to_each[shares.rank_of(points[i])], &values[i * length], length * sizeof(double));
    exchange(std::move(to_each));
  }
  void end() override { exchange(news({FieldNews::Kind::end, 0, 0})); }
  void drop(const std::string& what) override { exchange(news({FieldNews::Kind::drop, 0, 0}, what)); }

  /// Of rank 0: the others stop listening.
  void end_all() { exchange(news({FieldNews::Kind::none, 0, 0})); }
  void listen() {
    while (exchange(std::vector<partition::Bytes>(static_cast<std::size_t>(peers_.ranks())))) {
    }
  }

  FieldsShare share() {
    result_.num_points = num_points_;
    result_.fields.num_points = shares().count(peers_.rank());
    result_.dropped = std::move(drops_.dropped);
    return std::move(result_);
  }

 private:
  partition::EvenShares shares() const { return {num_points_, peers_.ranks()}; }
  std::vector<partition::Bytes> news(const FieldNews& said, const std::string& text = {}) const {
    partition::Bytes bytes = partition::bytes_of(std::vector{said});
    partition::append(bytes, text.data(), text.size());
    return {static_cast<std::size_t>(peers_.ranks()), bytes};
  }

  /// All ranks. Returns whether anything has been said.
  bool exchange(std::vector<partition::Bytes> to_each) {
    const partition::Bytes arrived = std::move(peers_.all_to_all(std::move(to_each))[0]);
    FieldNews said;
    std::memcpy(&said, arrived.data(), sizeof said);
    const std::span rest = std::span(arrived).subspan(sizeof said);
    const auto text = [&] { return std::string(reinterpret_cast<const char*>(rest.data()), rest.size()); };
    switch (said.kind) {
      case FieldNews::Kind::begin:
        num_points_ = said.points;
        field_.emplace(text(), said.length, shares().first(peers_.rank()), shares().count(peers_.rank()));
        break;
      case FieldNews::Kind::rows:
        add_rows(rest);
        break;
      case FieldNews::Kind::end:
        keep_or_drop();
        break;
      case FieldNews::Kind::drop:
        drops_.drop(text());
        break;
      case FieldNews::Kind::none:
        return false;
    }
    return true;
  }

  /// The points of some rows, and then their values.
  void add_rows(std::span<const std::byte> bytes) {
    const std::uint64_t length = field_->length();
    std::vector<std::uint32_t> points(bytes.size() / (sizeof(std::uint32_t) + length * sizeof(double)));
    std::vector<double> values(points.size() * length);
    if (points.empty()) return;
    std::memcpy(points.data(), bytes.data(), points.size() * sizeof points[0]);
    std::memcpy(values.data(), &bytes[points.size() * sizeof points[0]], values.size() * sizeof values[0]);
    field_->add(points, values);
  }

  void keep_or_drop() {
    if (partition::sum(peers_, field_->num_given()) < num_points_)
      return drops_.drop(meshing::kFieldsWithGaps);
    std::optional<Field> field = field_->take();
    if (partition::max(peers_, std::uint8_t{!field}) != 0) return drops_.drop(meshing::kSkewTensors);
    result_.fields.fields.push_back(std::move(*field));
  }

  Peers& peers_;
  std::uint64_t num_points_ = 0;
  std::optional<meshing::StreamedField> field_;
  FieldsShare result_;
  meshing::MeshContents drops_;
};

}  // namespace

MeshShare read_dealt_share(Peers& peers, const std::string& file, meshing::OtherVolumes others) {
  MeshShare share;
  DealtArrays arrays;
  Dealer dealer(peers, arrays);
  meshing::MeshContents rest;
  std::string problem;
  if (peers.rank() == 0) {
    try {
      rest = meshing::stream_mesh(file, dealer, others);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    dealer.end();
  } else {
    while (pass_block(peers, {}, {}, arrays)) {
    }
  }
  partition::agree(peers, problem);

  partition::MeshSlice& slice = share.slice;
  const Counts counts = partition::allgather(peers, std::vector{dealer.counts()})[0][0];
  slice.num_points = counts.of(Column::points);
  slice.num_tets = counts.of(Column::tets);
  slice.first_point = share_of(slice.num_points, peers.rank(), peers.ranks()).first;
  slice.first_tet = share_of(slice.num_tets, peers.rank(), peers.ranks()).first;
  slice.points = arrays[index_of(Column::points)].share<Point>(peers, slice.num_points);
  slice.point_refs = arrays[index_of(Column::point_refs)].share<std::int32_t>(peers, slice.num_points);
  slice.tets = arrays[index_of(Column::tets)].share<Tet>(peers, slice.num_tets);
  const Column tet_refs = counts.prefers_other[3] != 0 ? Column::other_tet_refs : Column::tet_refs;
  slice.tet_refs = arrays[index_of(tet_refs)].share<std::int32_t>(peers, slice.num_tets);
  set_point_refs(peers, dealer.refs_of_points(), slice);
  deal_boundary(peers, rest.mesh, slice);
  add_boundary(peers, counts, arrays, slice);
  share.names = std::move(rest.names);
  share.dropped = std::move(rest.dropped);
  return share;
}

FieldsShare read_dealt_fields(Peers& peers, const std::string& file) {
  DealtFields fields(peers);
  std::string problem;
  if (peers.rank() == 0) {
    try {
      meshing::stream_fields(file, fields);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    fields.end_all();
  } else {
    fields.listen();
  }
  partition::agree(peers, problem);
  return fields.share();
}

}  // namespace weft::tools
