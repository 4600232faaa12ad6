// Every rank that is asked answers with the best place that it has; the best of these is that of the whole
// mesh (tet_locator.h): the owner of a vertex has all tets at it, and so all that hold a point of these tets.
#include "partition/fields/read_at_vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/base/sort_unique.h"
#include "meshing/fields/interpolate.h"
#include "meshing/fields/tet_locator.h"
#include "meshing/mesh/adjacency.h"
#include "partition/communication/agreement.h"
#include "partition/fields/box_tree.h"
#include "partition/fields/cell_homes.h"
#include "partition/fields/surroundings.h"

namespace weft::partition {
namespace {

using meshing::Box;
using meshing::Point;
using meshing::TetLocator;

/// Where a rank reads a point. Tets have the numbers of the whole mesh.
struct Found {
  double distance2 = std::numeric_limits<double>::infinity();
  double six_volume = 0;
  std::array<std::uint32_t, 4> tet{};
  std::uint32_t face = 0, inside = 0;

  /// The rule of TetLocator.
  bool comes_before(const Found& other) const {
    const auto key = [](const Found& p) {
      return std::tuple(p.inside == 0, p.distance2, -p.six_volume, p.tet, p.face);
    };
    return key(*this) < key(other);
  }
};

/// What one rank reads for others.
class Reader {
 public:
  Reader(const PartDomain& domain, const meshing::ValueTable& values) : domain_(domain), values_(values) {
    const meshing::MeshData& mesh = domain.mesh();
    if (!mesh.tets.empty())
      locator_.emplace(mesh, meshing::build_adjacency(mesh.tets, mesh.points.size()),
                       [&](std::uint32_t v) { return !domain.owns(v); });
  }

  /// One place a point, and a value of each column.
  std::pair<std::vector<Found>, std::vector<double>> read(std::span<const Point> points) const {
    constexpr std::size_t kPiece = 256;  // each point is looked for from where the one before it is
    std::vector<Found> places(points.size());
    std::vector<double> values(points.size() * values_.columns, 0);
    meshing::for_each_large((points.size() + kPiece - 1) / kPiece, [&](std::size_t piece) {
      std::uint32_t hint = TetLocator::kNoHint;
      for (std::size_t i = piece * kPiece; i < std::min(points.size(), (piece + 1) * kPiece); ++i) {
        const TetLocator::Place found = locator_->locate(points[i], hint);
        hint = found.tet;
        places[i] = in_whole_mesh(found);
        meshing::read_at(found, domain_.mesh().tets[found.tet], values_, values.data() + i * values_.columns);
      }
    });
    return {std::move(places), std::move(values)};
  }

 private:
  Found in_whole_mesh(const TetLocator::Place& found) const {
    const meshing::MeshData& mesh = domain_.mesh();
    const auto& [a, b, c, d] = mesh.tets[found.tet];
    const auto& numbers = domain_.numbers();
    return {found.distance2,
            six_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]),
            {numbers[a], numbers[b], numbers[c], numbers[d]},
            found.face,
            found.inside ? 1u : 0u};
  }

  const PartDomain& domain_;
  const meshing::ValueTable& values_;
  std::optional<TetLocator> locator_;
};

/// Who has tets near points.
class Neighbourhood {
 public:
  Neighbourhood(Peers& peers, const PartDomain& of, const PartDomain& at)
      : peers_(peers), grid_(common_grid(peers, of, at)), boxes_(boxes_of_tets(of.mesh(), kMostBoxes)) {}

  /// All ranks: for each rank, those of the boxes that meet its tets, or come near.
  std::vector<std::vector<std::uint32_t>> near(std::span<const Box> boxes) {
    std::vector<int> asked;
    for (const auto& ranks : ranks_wanting(peers_, grid_, grid_.cells_of(boxes), grid_.cells_of(boxes_)))
      asked.insert(asked.end(), ranks.begin(), ranks.end());
    meshing::sort_unique(asked);
    Box all;
    for (const Box& box : boxes) all.unite(box);
    const std::vector<std::vector<Box>> of_each = ask_for_boxes(peers_, asked, all, boxes_);
    std::vector<std::vector<std::uint32_t>> near(of_each.size());
    for (std::size_t r = 0; r < of_each.size(); ++r) {
      if (of_each[r].empty()) continue;
      BoxTree tree(of_each[r]);
      for (std::uint32_t i = 0; i < boxes.size(); ++i)
        if (tree.meets(boxes[i])) near[r].push_back(i);
    }
    return near;
  }

 private:
  static constexpr std::size_t kMostBoxes = 1024;
  Peers& peers_;
  CellGrid grid_;
  std::vector<Box> boxes_;  ///< of this rank's tets
};

/// The points of one rank, and the best that is known of each.
class Points {
 public:
  Points(const PartDomain& at, std::size_t columns, double diameter)
      : at_(at),
        diameter_(diameter),
        places_(at.mesh().points.size()),
        reach_(places_.size(), 0),
        table_{columns, std::vector<double>(places_.size() * columns, 0)} {
    for (std::uint32_t v = 0; v < places_.size(); ++v)
      if (at.owns(v)) pending_.push_back(v);
  }

  /// All ranks: of the points that may have a better place farther off, asks who is near.
  void ask(Peers& peers, Neighbourhood& neighbourhood, const Reader& reader) {
    std::vector<Box> boxes;
    for (const std::uint32_t v : pending_) {
      const Point& p = at_.mesh().points[v];
      boxes.push_back(Box{p, p}.grown(reach_[v]));
    }
    const std::vector<std::vector<std::uint32_t>> near = neighbourhood.near(boxes);
    std::vector<std::vector<Point>> questions(near.size());
    for (std::size_t r = 0; r < near.size(); ++r)
      for (const std::uint32_t i : near[r]) questions[r].push_back(at_.mesh().points[pending_[i]]);
    questions = partition::all_to_all(peers, std::move(questions));
    std::vector<std::vector<Found>> places(near.size());
    std::vector<std::vector<double>> values(near.size());
    for (std::size_t r = 0; r < near.size(); ++r)
      if (!questions[r].empty()) std::tie(places[r], values[r]) = reader.read(questions[r]);
    places = partition::all_to_all(peers, std::move(places));
    values = partition::all_to_all(peers, std::move(values));
    for (std::size_t r = 0; r < near.size(); ++r)
      for (std::size_t k = 0; k < near[r].size(); ++k)
        hear(pending_[near[r][k]], places[r][k], values[r].data() + k * table_.columns);
    std::erase_if(pending_, [&](std::uint32_t v) {
      return places_[v].inside || !widen_reach(std::sqrt(places_[v].distance2), diameter_, reach_[v]);
    });
  }

  /// All ranks.
  bool all_are_read() const { return !at_.any(!pending_.empty()); }
  meshing::ValueTable take() {
    at_.refresh(table_.columns, table_.values);
    return std::move(table_);
  }

 private:
  void hear(std::uint32_t v, const Found& place, const double* values) {
    if (!place.comes_before(places_[v])) return;
    places_[v] = place;
    std::copy_n(values, table_.columns, table_.values.data() + v * table_.columns);
  }

  const PartDomain& at_;
  double diameter_;
  std::vector<Found> places_;
  std::vector<double> reach_;
  meshing::ValueTable table_;
  std::vector<std::uint32_t> pending_;
};

}  // namespace

meshing::ValueTable read_at_vertices(Peers& peers, const PartDomain& of, const meshing::ValueTable& values,
                                     const PartDomain& at, double diameter) {
  std::optional<Reader> reader;
  agree_on(peers, [&] { reader.emplace(of, values); });
  Neighbourhood neighbourhood(peers, of, at);
  Points points(at, values.columns, diameter);
  do points.ask(peers, neighbourhood, *reader);
  while (!points.all_are_read());
  return points.take();
}

}  // namespace weft::partition
