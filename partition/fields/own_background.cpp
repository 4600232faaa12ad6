// Points are found by whoever has what is near; pieces go to who has tets near them, who keeps those that
// meet a tet.
#include "partition/fields/own_background.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <tuple>
#include <utility>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/fields/reading.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/reduce.h"
#include "partition/distribute/point_records.h"
#include "partition/fields/cell_homes.h"
#include "partition/fields/tets_meet.h"
#include "partition/slice/used_numbers.h"

namespace weft::partition {
namespace {

using meshing::Box;
using meshing::Point;
using meshing::Tet;

TetCorners corners_of(std::span<const Point> points, const Tet& t) {
  return {points[t[0]], points[t[1]], points[t[2]], points[t[3]]};
}

meshing::ValueTable table_of(const meshing::LogMetricField& field) {
  meshing::ValueTable table{6, {}};
  table.values.reserve(6 * field.size());
  for (const meshing::LogMetric& l : field)
    table.values.insert(table.values.end(), {l.xx, l.xy, l.yy, l.xz, l.yz, l.zz});
  return table;
}

meshing::LogMetricField field_of(const meshing::ValueTable& table) {
  meshing::LogMetricField field;
  field.reserve(table.values.size() / 6);
  for (std::size_t i = 0; i < table.values.size(); i += 6) {
    const double* l = table.values.data() + i;
    field.push_back({l[0], l[1], l[2], l[3], l[4], l[5]});
  }
  return field;
}

/// A tet on its way to its place in the order of all.
struct OrderedTet {
  std::uint64_t key;
  Tet tet;
  auto operator<=>(const OrderedTet&) const = default;
};

/// The tets of the part that are this rank's, numbered as in the whole mesh.
std::vector<OrderedTet> tets_here(Peers& peers, const PartDomain& domain) {
  const meshing::MeshData& mesh = domain.mesh();
  const Box box = common_box(peers, meshing::box_of(mesh.points));
  std::vector<Tet> tets;
  std::vector<Point> centres;
  for (const Tet& tet : mesh.tets) {
    if (!domain.owns(std::ranges::min(tet))) continue;
    const TetCorners x = corners_of(mesh.points, tet);
    centres.push_back(0.25 * (x[0] + x[1] + (x[2] + x[3])));
    tets.push_back(tet);
    for (std::uint32_t& v : tets.back()) v = domain.numbers()[v];
  }
  const std::vector<std::uint64_t> keys = morton_keys(centres, box);
  std::vector<OrderedTet> ordered;
  ordered.reserve(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) ordered.push_back({keys[t], tets[t]});
  return ordered;
}

/// All ranks: the tets of all in order, each rank those of whole pieces.
std::vector<Tet> in_pieces(Peers& peers, std::vector<OrderedTet>&& mine) {
  std::vector<std::uint64_t> keys;
  for (const OrderedTet& tet : mine) keys.push_back(tet.key);
  const std::vector<std::uint64_t> firsts = first_keys(peers, std::move(keys));
  std::vector<std::vector<OrderedTet>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const OrderedTet& tet : mine)
    to_each[static_cast<std::size_t>(std::ranges::upper_bound(firsts, tet.key) - firsts.begin())].push_back(
        tet);
  mine.clear();
  for (const auto& of_rank : partition::all_to_all(peers, to_each))
    mine.insert(mine.end(), of_rank.begin(), of_rank.end());
  std::ranges::sort(mine);
  const Ranges tets(peers, mine.size());  // a piece is with its first tet
  std::vector<std::vector<Tet>> to_first(to_each.size());
  for (std::size_t t = 0; t < mine.size(); ++t) {
    const std::uint64_t number = tets.first(peers.rank()) + t;
    to_first[tets.rank_of(number - number % kTetsOfPiece)].push_back(mine[t].tet);
  }
  std::vector<Tet> of_pieces;
  for (const auto& of_rank : partition::all_to_all(peers, to_first))
    of_pieces.insert(of_pieces.end(), of_rank.begin(), of_rank.end());
  return of_pieces;
}

/// Pieces one after the other, each behind its size.
void append_background_piece(const BackgroundPiece& piece, Bytes& bytes) {
  const std::uint64_t size = piece.bytes().size();
  const auto first = reinterpret_cast<const std::byte*>(&size);
  bytes.insert(bytes.end(), first, first + sizeof size);
  bytes.insert(bytes.end(), piece.bytes().begin(), piece.bytes().end());
}

/// `bytes` begins with it, and with what is behind it afterwards.
std::shared_ptr<const BackgroundPiece> take_background_piece(std::span<const std::byte>& bytes) {
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  const auto words = std::make_shared<std::vector<std::uint64_t>>(size / sizeof(std::uint64_t));
  std::memcpy(words->data(), bytes.data() + sizeof size, size);
  bytes = bytes.subspan(sizeof size + size);
  return std::make_shared<const BackgroundPiece>(std::as_bytes(std::span(*words)), words);
}

/// A few tets of the starts a cell.
CellGrid grid_over(Peers& peers, std::span<const SubdomainStart> starts,
                   std::span<const std::shared_ptr<const BackgroundPiece>> pieces) {
  constexpr double kTetsPerCell = 8;
  Box mine;
  std::uint64_t tets = 0;
  for (const SubdomainStart& s : starts) {
    for (const Point& p : s.points) mine.include(p);
    tets += s.tets.size();
  }
  for (const auto& piece : pieces)
    for (const Point& p : piece->points) mine.include(p);
  return {common_box(peers, mine), static_cast<double>(partition::sum(peers, tets)) / kTetsPerCell};
}

/// Which tets of a start a tet of the background may meet.
class StartIndex {
 public:
  explicit StartIndex(const SubdomainStart& s)
      : start_(s), box_(meshing::box_of(s.points)), grid_(box_, static_cast<double>(s.tets.size()) / 4) {
    in_cell_.resize(grid_.size());
    for (std::uint32_t t = 0; t < s.tets.size(); ++t)
      grid_.for_each_cell(box_of(corners_of(s.points, s.tets[t])),
                          [&](std::uint32_t cell) { in_cell_[cell].push_back(t); });
  }

  bool meets(const BackgroundPiece& piece) const {
    return box_.meets(meshing::box_of(piece.points)) && std::ranges::any_of(piece.tets, [&](const Tet& tet) {
             return meets(corners_of(piece.points, tet));
           });
  }

 private:
  bool meets(const TetCorners& tet) const {
    const Box box = box_of(tet);
    if (!box.meets(box_)) return false;
    bool found = false;
    grid_.for_each_cell(box, [&](std::uint32_t cell) {
      for (std::size_t i = 0; i < in_cell_[cell].size() && !found; ++i) {
        const TetCorners mine = corners_of(start_.points, start_.tets[in_cell_[cell][i]]);
        found = box.meets(box_of(mine)) && tets_meet(tet, mine);
      }
    });
    return found;
  }

  const SubdomainStart& start_;
  Box box_;
  CellGrid grid_;
  std::vector<std::vector<std::uint32_t>> in_cell_;
};

}  // namespace

OwnBackground::OwnBackground(Peers& peers, MeshSlice&& background, MeshSlice& input)
    : peers_(peers), input_points_(peers, input.points.size()) {
  std::vector<Tet> places;
  {
    PartPair meshes(peers, background, input);
    complexity_ = meshes.old_mesh().complexity(meshes.old_mesh().from_slices(background.log_metrics));
    places = places_of(meshes, background, input);
    cut(meshes.old_mesh(), background);
  }
  background = {};
  places_ = names_of(places);
}

/// Reads the metric of the input's points; returns the tet of each, numbered as in the whole background.
std::vector<Tet> OwnBackground::places_of(PartPair& meshes, const MeshSlice& background, MeshSlice& input) {
  const meshing::LogMetricField at_part = meshes.old_mesh().from_slices(background.log_metrics);
  const meshing::Reading reading = meshing::read(meshes, table_of(at_part));
  uncovered_ = meshing::uncovered(meshes, reading);
  input.log_metrics = meshes.new_mesh().to_slices(field_of(reading.at.table));
  const std::vector<std::uint64_t>& numbers = meshes.source_numbers();
  const meshing::MeshData& source = meshes.source();
  std::vector<Tet> places;
  for (const std::uint32_t t : reading.at.places) {
    Tet& place = places.emplace_back();
    for (std::size_t i = 0; i < 4; ++i) place[i] = static_cast<std::uint32_t>(numbers[source.tets[t][i]]);
  }
  return meshes.new_mesh().to_slices(places);
}

void OwnBackground::cut(const PartDomain& domain, const MeshSlice& background) {
  tets_ = in_pieces(peers_, tets_here(peers_, domain));
  const std::vector<std::uint32_t> numbers = used_numbers(tets_);
  const Ranges ranges(peers_, background.points.size());
  const std::vector<PointRecord> records = fetch_points(peers_, background, ranges, numbers);
  std::vector<Point> points;
  meshing::LogMetricField log_metrics;
  std::vector<GlobalId> ids;
  for (const PointRecord& record : records) {
    points.push_back(record.point);
    log_metrics.push_back(record.log_metric);
    ids.emplace_back(SubdomainId(0), record.number);
  }
  std::vector<Tet> tets = tets_;
  for (Tet& tet : tets)
    for (std::uint32_t& v : tet) v = static_cast<std::uint32_t>(meshing::place_in(numbers, v));
  const Ranges pieces(peers_, (tets.size() + kTetsOfPiece - 1) / kTetsOfPiece);
  for (int r = 0; r < peers_.ranks(); ++r) firsts_.push_back(pieces.first(r));
  firsts_.push_back(pieces.total());
  pieces_ = cut_background(kOfAnotherMesh | pieces.first(peers_.rank()), points, log_metrics, ids, tets);
}

/// All ranks: names of tets and questions for them meet at a rank that the first vertex decides.
std::vector<BackgroundTet> OwnBackground::names_of(const std::vector<Tet>& tets) const {
  struct Named {
    Tet tet;
    std::uint32_t in_piece, unused;
    std::uint64_t piece;
  };
  const auto ranks = static_cast<std::uint32_t>(peers_.ranks());
  std::vector<std::vector<Named>> names(ranks);
  for (std::uint32_t t = 0; t < tets_.size(); ++t)
    names[tets_[t][0] % ranks].push_back(
        {tets_[t], t % static_cast<std::uint32_t>(kTetsOfPiece), 0, pieces_[t / kTetsOfPiece]->id});
  std::vector<Named> here;
  for (const auto& of_rank : partition::all_to_all(peers_, names))
    here.insert(here.end(), of_rank.begin(), of_rank.end());
  names.clear();
  std::ranges::sort(here, {}, &Named::tet);
  std::vector<std::vector<Tet>> asked(ranks);
  for (const Tet& tet : tets) asked[tet[0] % ranks].push_back(tet);
  asked = partition::all_to_all(peers_, asked);
  std::vector<std::vector<BackgroundTet>> answers(ranks);
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const Tet& tet : asked[r]) {
      const auto at = std::ranges::lower_bound(here, tet, {}, &Named::tet);
      answers[r].push_back({at->piece, at->in_piece});
    }
  answers = partition::all_to_all(peers_, answers);
  std::vector<std::size_t> next(ranks, 0);
  std::vector<BackgroundTet> named;
  named.reserve(tets.size());
  for (const Tet& tet : tets) {
    const std::size_t home = tet[0] % ranks;
    named.push_back(answers[home][next[home]++]);
  }
  return named;
}

std::size_t OwnBackground::rank_of(std::uint64_t piece) const {
  const auto after = std::ranges::upper_bound(firsts_.begin(), firsts_.end() - 1, piece & ~kOfAnotherMesh);
  return static_cast<std::size_t>(after - firsts_.begin()) - 1;
}

/// For each rank the places in pieces_ of what is in a cell where it has tets.
std::vector<std::vector<std::uint64_t>> OwnBackground::wanted_by_cells(
    std::span<const SubdomainStart> starts) const {
  const CellGrid grid = grid_over(peers_, starts, pieces_);
  std::vector<std::uint32_t> had, wanted;
  const auto add_cells = [&](std::span<const Point> points, std::span<const Tet> tets,
                             std::vector<std::uint32_t>& cells) {
    for (const Tet& tet : tets)
      grid.for_each_cell(box_of(corners_of(points, tet)), [&](std::uint32_t c) { cells.push_back(c); });
    meshing::sort_unique(cells);
  };
  for (const SubdomainStart& s : starts) add_cells(s.points, s.tets, wanted);
  std::vector<std::vector<std::uint32_t>> cells(pieces_.size());
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    add_cells(pieces_[p]->points, pieces_[p]->tets, cells[p]);
    had.insert(had.end(), cells[p].begin(), cells[p].end());
  }
  meshing::sort_unique(had);
  const std::vector<std::vector<int>> ranks = ranks_wanting(peers_, grid, had, wanted);
  std::vector<std::vector<std::uint64_t>> pieces(static_cast<std::size_t>(peers_.ranks()));
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    for (const std::uint32_t cell : cells[p])
      for (const int rank : ranks[meshing::place_in(had, cell)]) {
        auto& list = pieces[static_cast<std::size_t>(rank)];
        if (list.empty() || list.back() != p) list.push_back(p);
      }
  return pieces;
}

/// Those that tets of the starts may meet, and those in which their vertices are; by id.
OwnBackground::Pieces OwnBackground::fetch_pieces(std::span<const SubdomainStart> starts) const {
  std::vector<std::vector<std::uint64_t>> to_each = wanted_by_cells(starts);
  std::vector<std::vector<std::uint64_t>> asked(to_each.size());
  for (const SubdomainStart& s : starts)
    for (const BackgroundTet& place : s.background_places) asked[rank_of(place.piece)].push_back(place.piece);
  for (auto& ids : asked) meshing::sort_unique(ids);
  asked = partition::all_to_all(peers_, asked);
  std::vector<Bytes> parcels;
  for (std::size_t r = 0; r < to_each.size(); ++r) {
    for (const std::uint64_t id : asked[r]) to_each[r].push_back(id - pieces_.front()->id);
    meshing::sort_unique(to_each[r]);
    Bytes parcel;
    for (const std::uint64_t p : to_each[r]) append_background_piece(*pieces_[p], parcel);
    parcels.push_back(std::move(parcel));
  }
  Pieces here;
  for (const Bytes& parcel : peers_.all_to_all(std::move(parcels)))
    for (std::span<const std::byte> rest(parcel); !rest.empty();) here.push_back(take_background_piece(rest));
  return here;
}

void OwnBackground::deliver(std::span<SubdomainStart> starts) const {
  std::vector<std::uint64_t> numbers;
  for (const SubdomainStart& s : starts)
    for (const GlobalId id : s.ids) numbers.push_back(id.local());
  meshing::sort_unique(numbers);
  const auto places =
      fetch<BackgroundTet>(peers_, input_points_, numbers, [&](std::size_t i) { return places_[i]; });
  for (SubdomainStart& s : starts)
    for (const GlobalId id : s.ids)
      s.background_places.push_back(places[meshing::place_in(numbers, id.local())]);
  const Pieces near = fetch_pieces(starts);
  for (SubdomainStart& s : starts) {
    if (s.tets.empty()) continue;
    std::vector<std::uint64_t> of_places;
    for (const BackgroundTet& place : s.background_places) of_places.push_back(place.piece);
    meshing::sort_unique(of_places);
    const StartIndex index(s);
    for (const auto& piece : near)
      if (std::ranges::binary_search(of_places, piece->id) || index.meets(*piece))
        s.background.push_back(piece);
  }
}

}  // namespace weft::partition
