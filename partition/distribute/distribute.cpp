// The steps of the distribution, in their order.
#include "partition/distribute/distribute.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "meshing/base/parallel.h"
#include "meshing/base/place_in.h"
#include "meshing/base/release.h"
#include "meshing/metric/expectations.h"
#include "meshing/metric/measure_lanes.h"
#include "partition/communication/home_rank.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/communication/same_arithmetic.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/decompose/decomposition.h"
#include "partition/decompose/inertia.h"
#include "partition/decompose/runs.h"
#include "partition/decompose/tet_measures.h"
#include "partition/distribute/point_records.h"
#include "partition/distribute/start_builder.h"
#include "partition/refine/refine_interface.h"
#include "partition/slice/slice_checks.h"
#include "partition/slice/used_numbers.h"
#include "partition/surface/boundary_index.h"
#include "partition/surface/boundary_share.h"
#include "partition/surface/surface_parts.h"
#include "partition/surface/surface_pieces.h"

namespace weft::partition {
namespace {

using meshing::Point;

/// The points that the slice's tets need, from anywhere: those of placed.numbers.
class TetPoints {
 public:
  TetPoints(Peers& peers, const MeshSlice& slice, const Ranges& ranges, const PlacedTets& placed)
      : tets_(placed.tets), records_(fetch_points(peers, slice, ranges, placed.numbers)) {}
  std::array<const PointRecord*, 4> of(std::size_t t) const {
    const auto& [a, b, c, d] = tets_[t];
    return {&records_[a], &records_[b], &records_[c], &records_[d]};
  }
  const std::array<std::uint32_t, 4>& places(std::size_t t) const { return tets_[t]; }
  TetCorners corners(std::size_t t) const {
    const auto [a, b, c, d] = of(t);
    return {a->point, b->point, c->point, d->point};
  }
  std::array<meshing::LogMetric, 4> log_metrics(std::size_t t) const {
    const auto [a, b, c, d] = of(t);
    return {a->log_metric, b->log_metric, c->log_metric, d->log_metric};
  }
  const std::vector<PointRecord>& all() const { return records_; }

 private:
  std::span<const std::array<std::uint32_t, 4>> tets_;
  std::vector<PointRecord> records_;
};

/// What is known of the slice's tets, and of the whole mesh, before it is decomposed.
struct Measured {
  std::vector<double> expected;                                ///< expected_complexity() of each tet
  double complexity = 0, mean_quality = 0, largest_share = 0;  ///< InputMeasures
  meshing::Box box;
};

std::vector<double> complexities_of(const TetPoints& points, std::size_t num_tets) {
  std::vector<double> densities(points.all().size()), result(num_tets);
  meshing::for_each_index(densities.size(),
                          [&](std::size_t i) { densities[i] = density(points.all()[i].log_metric); });
  meshing::for_each_index(num_tets, [&](std::size_t t) {
    const auto& [a, b, c, d] = points.places(t);
    result[t] = complexity(points.corners(t), {densities[a], densities[b], densities[c], densities[d]});
  });
  return result;
}

std::vector<double> expected_complexities(const TetPoints& points, std::size_t num_tets) {
  std::vector<double> result(num_tets);
  meshing::for_each_index(num_tets, [&](std::size_t t) {
    result[t] = expected_complexity(points.corners(t), points.log_metrics(t));
  });
  return result;
}

/// Weighed by complexity: what becomes few tets does not matter, however many it has now.
std::vector<double> weighed_qualities(const PlacedTets& placed, const TetPoints& points,
                                      std::span<const double> complexities) {
  std::vector<Point> x;
  std::vector<meshing::LogMetric> log_metrics;
  x.reserve(points.all().size());
  log_metrics.reserve(points.all().size());
  for (const PointRecord& record : points.all()) {
    x.push_back(record.point);
    log_metrics.push_back(record.log_metric);
  }
  constexpr std::size_t kLanes = meshing::kLanes;
  std::vector<double> weighed(placed.tets.size());
  meshing::for_each_index((weighed.size() + kLanes - 1) / kLanes, [&](std::size_t batch) {
    const std::size_t first = batch * kLanes;
    const meshing::Lanes ratios = meshing::mean_ratios(placed.tets, first, x, log_metrics);
    for (std::size_t t = first; t < std::min(first + kLanes, weighed.size()); ++t)
      weighed[t] = complexities[t] * std::max(0.0, ratios[t - first]);
  });
  return weighed;
}

meshing::Box box_of(Peers& peers, const TetPoints& points) {
  std::vector<Point> all;
  all.reserve(points.all().size());
  for (const PointRecord& record : points.all()) all.push_back(record.point);
  return group_boxes(peers, all, std::vector<std::uint32_t>(all.size(), 0), 1)[0];
}

std::optional<InputIssue> find_inverted(const MeshSlice& slice, const TetPoints& points) {
  const auto issue_of = [&](std::size_t t) {
    const auto p = points.of(t);
    return inverted(slice.first_tet + t, slice.tets[t],
                    {&p[0]->point, &p[1]->point, &p[2]->point, &p[3]->point});
  };
  const std::size_t t =
      meshing::find_first(slice.tets.size(), [&](std::size_t i) { return issue_of(i).has_value(); });
  if (t < slice.tets.size()) return issue_of(t);
  return {};
}

Measured check_and_measure(Peers& peers, const MeshSlice& slice, const PlacedTets& placed,
                           const TetPoints& points) {
  throw_first(peers, find_inverted(slice, points));
  const std::vector<double> complexities = complexities_of(points, slice.tets.size());
  const std::vector<double> qualities = weighed_qualities(placed, points, complexities);
  std::vector<double> expected = expected_complexities(points, slice.tets.size());
  const std::array<std::span<const double>, 3> lists = {complexities, qualities, expected};
  const std::vector<double> sums = ordered_sums(peers, lists);
  if (sums[0] <= 0) return {std::move(expected), sums[0], 0, 0, box_of(peers, points)};
  const double largest = partition::max(peers, expected.empty() ? 0 : std::ranges::max(expected));
  return {std::move(expected), sums[0], sums[1] / sums[0], sums[2] > 0 ? largest / sums[2] : 0,
          box_of(peers, points)};
}

/// M <- factor^(2/3) M.
void scale_metric(double factor, MeshSlice& slice) {
  const meshing::LogMetric shift =
      (2.0 / 3 * std::log(factor)) * meshing::LogMetric(meshing::identity_tensor(1));
  for (meshing::LogMetric& l : slice.log_metrics) l = l + shift;
}

/// All of which is scaled as the metric is. `expected`: of each tet, before.
TetMeasures measures_of(const TetPoints& points, std::span<const double> expected, double factor) {
  TetMeasures measures;
  measures.reserve(expected.size());
  for (std::size_t t = 0; t < expected.size(); ++t)
    measures.add(points.corners(t), points.log_metrics(t), expected[t]);
  if (factor != 1) measures.scale(factor);
  return measures;
}

/// How far each tet of the slice reaches along the coordinate.
std::vector<double> reaches(Peers& peers, const MeshSlice& slice, const Ranges& points,
                            const std::vector<double>& coordinate) {
  if (coordinate.size() != slice.points.size())
    throw std::invalid_argument("slabs along a coordinate of the boundary: the points have none");
  const std::vector<std::uint32_t> numbers = used_numbers(slice.tets);
  const std::vector<double> values =
      fetch<double>(peers, points, numbers, [&](std::size_t i) { return coordinate[i]; });
  const auto value = [&](std::uint32_t v) { return values[meshing::place_in(numbers, v)]; };
  std::vector<double> reach;
  reach.reserve(slice.tets.size());
  for (const auto& [a, b, c, d] : slice.tets)
    reach.push_back(std::max({value(a), value(b), value(c), value(d)}));
  return reach;
}

/// Into the subdomains that have tets at first. Gives the measures' memory back.
Decomposition decompose_slice(Peers& peers, const MeshSlice& slice, const Ranges& points,
                              TetMeasures&& measures, const DecompositionOptions& options,
                              std::uint32_t parts) {
  std::vector<double> work(slice.tets.size(), 1);
  if (!options.equal_tets) work = measures.work();
  std::vector<std::uint64_t> numbers(slice.tets.size());
  std::iota(numbers.begin(), numbers.end(), slice.first_tet);
  std::vector<double> along;
  const bool cut_at_once = parts == options.num_subdomains;
  if (cut_at_once && options.partitioner.coordinate.asked())
    along = reaches(peers, slice, points, options.coordinate);
  const Items items{
      measures.centres,    measures.corners,      work, numbers, measures.cut_tensors, slice.tets,
      measures.face_areas, measures.complexities, along};
  const auto items_are_read = [&] { measures = {}; };
  if (cut_at_once) return decompose(peers, items, parts, options.partitioner, items_are_read);
  Partitioner partitioner = options.partitioner;
  if (partitioner.kind == Partitioner::Kind::pqr) partitioner = {};  // its slabs are those of the whole
  return with_room_to_divide(peers, decompose(peers, items, parts, partitioner, items_are_read), work, parts,
                             options.num_subdomains);
}

/// Whether the mesh is nearly what the metric asks for, by the same numbers on all ranks.
bool is_nearly_right(const Distributed& d, std::uint64_t num_tets) {
  constexpr double kGoodMean = 0.85, kNearly = 1.25;
  const double wanted = meshing::kTetsOfUnitVolume * d.complexity, tets = static_cast<double>(num_tets);
  return d.mean_quality >= kGoodMean && tets < kNearly * wanted && wanted < kNearly * tets;
}

/// All ranks: the lowest part of a tet, on any rank, at each of the vertices.
std::vector<std::uint32_t> lowest_parts(Peers& peers, const Ranges& points, const PlacedTets& placed,
                                        std::span<const SubdomainId> parts) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::vector<std::uint32_t> lowest(placed.numbers.size(), kNone);
  for (std::size_t t = 0; t < parts.size(); ++t)
    for (const std::uint32_t v : placed.tets[t]) lowest[v] = std::min(lowest[v], parts[t].value);
  struct Known {
    std::uint32_t number, part;
  };
  std::vector<std::vector<Known>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t v = 0; v < lowest.size(); ++v)
    to_each[points.rank_of(placed.numbers[v])].push_back({placed.numbers[v], lowest[v]});
  const auto arrived = partition::all_to_all(peers, std::move(to_each));
  const std::uint64_t first = points.first(peers.rank());
  std::vector<std::uint32_t> of_point(points.first(peers.rank() + 1) - first, kNone);
  for (const auto& of_rank : arrived)
    for (const Known& k : of_rank) of_point[k.number - first] = std::min(of_point[k.number - first], k.part);
  std::vector<std::vector<std::uint32_t>> answers(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (const Known& k : arrived[r]) answers[r].push_back(of_point[k.number - first]);
  return all_to_all_joined(peers, std::move(answers));
}

/// Ends of runs stick out: a part takes all tets whose vertices it, or a lower one, has anyway, so that
/// interfaces run along whole balls.
void even_out(Peers& peers, const Ranges& points, const PlacedTets& placed, std::vector<SubdomainId>& parts) {
  const std::vector<std::uint32_t> lowest = lowest_parts(peers, points, placed, parts);
  for (std::size_t t = 0; t < parts.size(); ++t) {
    const auto& [a, b, c, d] = placed.tets[t];
    parts[t] = SubdomainId(std::max({lowest[a], lowest[b], lowest[c], lowest[d]}));
  }
}

/// In the middles of runs the metric says alone along which axis they are halved.
Decomposition decompose_by_runs(Peers& peers, const Ranges& ranges, const Ranges& tets,
                                const PlacedTets& placed, std::span<const double> work,
                                const TetPoints& points, std::uint32_t parts) {
  const auto sample = [&](std::size_t t) {
    const TetCorners corners = points.corners(t);
    const auto logs = points.log_metrics(t);
    return RunSample{corners,
                     cut_tensor(corners, unit_inverse(0.25 * (logs[0] + logs[1] + logs[2] + logs[3])))};
  };
  Decomposition result{bisect_runs(peers, tets, work, sample, parts), {}, {}};
  even_out(peers, ranges, placed, result.subdomains);
  return result;
}

/// Inner patches have two tets at every triangle. Patches are cut at features, so they are all inner or all
/// outer.
void find_inner_patches(Peers& peers, std::span<const std::uint64_t> triangles,
                        std::span<const SubdomainStart> starts, Geometry& geometry) {
  std::vector<std::uint64_t> faces(geometry.patch_inner.size(), 0);
  for (const SubdomainStart& s : starts)
    for (const auto& face : s.boundary_faces) ++faces[face.patch.value];
  faces = partition::sum(peers, faces);
  for (std::size_t p = 0; p < faces.size(); ++p) geometry.patch_inner[p] = faces[p] > triangles[p];
}

/// A copy of a vertex of the interface.
struct DelicateCopy {
  EntityKey<1> key;
  std::uint64_t delicate;
};

/// The flag of every copy of a vertex of the interface is that of any of them: they meet at the vertex's
/// home.
void share_delicate(Peers& peers, std::span<SubdomainStart> starts) {
  Rendezvous<1, DelicateCopy> mail(peers.ranks());
  const auto for_each_shared = [&](const auto& f) {
    for (SubdomainStart& s : starts)
      for (std::size_t i = 0; i < s.shared.size(); ++i)
        if (i == 0 || s.shared[i].vertex != s.shared[i - 1].vertex) f(s, s.shared[i].vertex);
  };
  for_each_shared([&](const SubdomainStart& s, std::uint32_t v) {
    mail.add({{s.ids[v]}, (s.flags[v] & kDelicate) != 0});
  });
  const auto arrived = mail.deliver(peers);
  std::vector<GlobalId> delicate;
  for (const auto& of_rank : arrived)
    for (const DelicateCopy& copy : of_rank)
      if (copy.delicate) delicate.push_back(copy.key[0]);
  std::sort(delicate.begin(), delicate.end());
  std::vector<std::vector<std::uint8_t>> answers(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (const DelicateCopy& copy : arrived[r])
      answers[r].push_back(std::binary_search(delicate.begin(), delicate.end(), copy.key[0]));
  const std::vector<std::uint8_t> mine = mail.answer(peers, answers);
  auto answer = mine.begin();
  for_each_shared([&](SubdomainStart& s, std::uint32_t v) {
    if (*answer++) s.flags[v] |= kDelicate;
  });
}

/// Vertices of tets so thin that rounding could invert them are marked in all copies.
void mark_delicate(Peers& peers, std::span<SubdomainStart> starts) {
  meshing::for_each_large(starts.size(), [&](std::size_t i) {
    SubdomainStart& s = starts[i];
    for (const auto& t : s.tets)
      if (is_delicate({s.points[t[0]], s.points[t[1]], s.points[t[2]], s.points[t[3]]}))
        for (const std::uint32_t v : t) s.flags[v] |= kDelicate;
  });
  share_delicate(peers, starts);
}

void check_options(const DecompositionOptions& options) {
  constexpr std::uint32_t kMost =
      (1u << (63 - GlobalId::kLocalBits)) - 2;  // the highest bit is that of derived names
  if (options.num_subdomains == 0 || options.num_subdomains > kMost)
    throw std::invalid_argument(
        fmt::format("the number of subdomains is {}, not one of 1..{}", options.num_subdomains, kMost));
}

}  // namespace

Distributed distribute(Peers& peers, MeshSlice&& slice, const DecompositionOptions& options) {
  check_options(options);
  check_same_arithmetic(peers);
  const std::vector<Ranges> ranges = Ranges::of_arrays(peers, {slice.points.size(), slice.tets.size()});
  const Ranges &points = ranges[0], &tets = ranges[1];
  check_slices(peers, slice, points, tets);
  Distributed result;
  PlacedTets placed = partition::placed(slice.tets);
  std::optional<TetPoints> tet_points(std::in_place, peers, slice, points, placed);
  Measured measured = check_and_measure(peers, slice, placed, *tet_points);
  result.mean_quality = measured.mean_quality;
  result.complexity = measured.complexity;
  double factor = 1;
  if (options.target_complexity > 0 && result.complexity > 0) {
    factor = options.target_complexity / result.complexity;
    scale_metric(factor, slice);
    result.complexity = options.target_complexity;
  }
  BoundaryShare boundary = complete_boundary(peers, slice, placed, points, tets);
  result.box = measured.box;
  const std::uint32_t parts = options.parts_at_first
                                  ? options.parts_at_first({slice.num_tets, result.complexity,
                                                            result.mean_quality, measured.largest_share})
                                  : options.num_subdomains;
  Decomposition decomposition;
  result.cut_by_runs = parts == options.num_subdomains && options.partitioner.runs_suffice &&
                       !options.equal_tets && is_nearly_right(result, slice.num_tets) &&
                       follow_each_other(peers, slice.tets);
  if (result.cut_by_runs) {
    for (double& c : measured.expected) c *= factor;
    decomposition =
        decompose_by_runs(peers, points, tets, placed, work_of(measured.expected), *tet_points, parts);
  } else {
    decomposition = decompose_slice(peers, slice, points, measures_of(*tet_points, measured.expected, factor),
                                    options, parts);
  }
  result.seeds = std::move(decomposition.seeds);
  measured = {};
  tet_points.reset();
  placed = {};

  const std::vector<TetRecord> mine =
      send_tets_home(peers, slice, std::exchange(decomposition.subdomains, {}), options.num_subdomains);
  const std::vector<PointRecord> records = fetch_points(peers, slice, points, vertices_of(mine));
  meshing::release(slice.point_refs);
  meshing::release(slice.log_metrics);
  const Holders holders = find_holders(peers, mine, options.num_subdomains);
  result.warnings = std::exchange(boundary.warnings, {});
  SurfaceParts surface = build_surface_parts(
      peers, std::move(boundary),
      [&](const std::vector<std::uint32_t>& wanted) {
        return fetch<Point>(peers, points, wanted, [&](std::size_t i) { return slice.points[i]; });
      },
      options.ridge_angle_degrees, options.model, result.warnings);
  meshing::release(slice.points);
  result.geometry = surface.geometry;
  std::vector<std::uint32_t> numbers;
  for (const PointRecord& record : records) numbers.push_back(record.number);
  const BoundaryIndex index(peers, std::exchange(surface.records, {}), numbers);
  std::vector<std::pair<SubdomainId, std::span<const TetRecord>>> tets_of;
  auto begin = mine.begin();
  for (SubdomainId s(0); s.value < options.num_subdomains; ++s.value) {
    if (home_rank(s, options.num_subdomains, peers.ranks()) != peers.rank()) continue;
    const auto end = std::find_if(begin, mine.end(), [&](const TetRecord& t) { return t.subdomain != s; });
    tets_of.push_back({s, {begin, end}});
    begin = end;
  }
  result.starts.resize(tets_of.size());
  meshing::for_each_large(tets_of.size(), [&](std::size_t i) {
    const auto& [s, of_start] = tets_of[i];
    result.starts[i] = build_start(s, of_start, records, holders, index, result.cut_by_runs);
  });
  find_inner_patches(peers, surface.triangles, result.starts, *surface.geometry);
  hand_out_pieces(peers, surface.cutter.get(), result.starts);
  surface = {};
  mark_delicate(peers, result.starts);
  if (!decomposition.warning.empty()) result.warnings.push_back(decomposition.warning);
  if (holders.used < slice.num_points)
    result.warnings.push_back(
        fmt::format("{} points that belong to no tet were dropped", slice.num_points - holders.used));
  return result;
}

}  // namespace weft::partition
