// The steps of the distribution, in their order.
#include "partition/distribute/distribute.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "partition/communication/home_rank.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/communication/same_arithmetic.h"
#include "partition/communication/sort_unique.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/decompose/decomposition.h"
#include "partition/decompose/inertia.h"
#include "partition/decompose/tet_measures.h"
#include "partition/distribute/boundary_index.h"
#include "partition/distribute/point_records.h"
#include "partition/distribute/slice_checks.h"
#include "partition/distribute/start_builder.h"
#include "partition/distribute/whole_boundary.h"
#include "partition/refine/refine_interface.h"

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
  const std::vector<PointRecord>& all() const { return records_; }

 private:
  std::span<const std::array<std::uint32_t, 4>> tets_;
  std::vector<PointRecord> records_;
};

/// What the decomposition wants to know of the slice's tets, and the box of the whole mesh.
struct Measured {
  TetMeasures tets;
  meshing::Box box;
};

Measured measure_tets(Peers& peers, const MeshSlice& slice, const TetPoints& points) {
  Measured m;
  m.tets.reserve(slice.tets.size());
  for (std::size_t t = 0; t < slice.tets.size(); ++t) {
    const auto p = points.of(t);
    m.tets.add({p[0]->point, p[1]->point, p[2]->point, p[3]->point},
               {p[0]->log_metric, p[1]->log_metric, p[2]->log_metric, p[3]->log_metric});
  }
  std::vector<Point> all;
  all.reserve(points.all().size());
  for (const PointRecord& record : points.all()) all.push_back(record.point);
  m.box = group_boxes(peers, all, std::vector<std::uint32_t>(all.size(), 0), 1)[0];
  return m;
}

std::optional<InputIssue> find_inverted(const MeshSlice& slice, const TetPoints& points) {
  for (std::size_t t = 0; t < slice.tets.size(); ++t) {
    const auto p = points.of(t);
    if (auto issue = inverted(slice.first_tet + t, slice.tets[t],
                              {&p[0]->point, &p[1]->point, &p[2]->point, &p[3]->point}))
      return issue;
  }
  return {};
}

Measured check_and_measure(Peers& peers, const MeshSlice& slice, const Ranges& ranges,
                           const PlacedTets& placed) {
  const TetPoints points(peers, slice, ranges, placed);
  throw_first(peers, find_inverted(slice, points));
  return measure_tets(peers, slice, points);
}

/// M <- (target/C)^(2/3) M, here and in what has been measured. Returns the complexity.
double scale_metric(Peers& peers, double target, MeshSlice& slice, TetMeasures& measures) {
  const double complexity = ordered_sum(peers, measures.complexities);
  if (target <= 0 || !(complexity > 0)) return complexity;
  const double factor = target / complexity;
  const meshing::LogMetric shift =
      (2.0 / 3 * std::log(factor)) * meshing::LogMetric(meshing::identity_tensor(1));
  for (meshing::LogMetric& l : slice.log_metrics) l = l + shift;
  measures.scale(factor);
  return target;
}

/// How far each tet of the slice reaches along the coordinate.
std::vector<double> reaches(Peers& peers, const MeshSlice& slice, const Ranges& points,
                            const std::vector<double>& coordinate) {
  if (coordinate.size() != slice.points.size())
    throw std::invalid_argument("slabs along a coordinate of the boundary: the points have none");
  std::vector<std::uint32_t> numbers;
  for (const auto& tet : slice.tets) numbers.insert(numbers.end(), tet.begin(), tet.end());
  sort_unique(numbers);
  const std::vector<double> values =
      fetch<double>(peers, points, numbers, [&](std::size_t i) { return coordinate[i]; });
  const auto value = [&](std::uint32_t v) {
    return values[static_cast<std::size_t>(std::ranges::lower_bound(numbers, v) - numbers.begin())];
  };
  std::vector<double> reach;
  reach.reserve(slice.tets.size());
  for (const auto& [a, b, c, d] : slice.tets)
    reach.push_back(std::max({value(a), value(b), value(c), value(d)}));
  return reach;
}

/// Into the subdomains that have tets at first.
Decomposition decompose_slice(Peers& peers, const MeshSlice& slice, const Ranges& points,
                              const TetMeasures& measures, const DecompositionOptions& options,
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
  if (cut_at_once) return decompose(peers, items, parts, options.partitioner);
  Partitioner partitioner = options.partitioner;
  if (partitioner.kind == Partitioner::Kind::pqr) partitioner = {};  // its slabs are those of the whole
  return with_room_to_divide(peers, decompose(peers, items, parts, partitioner), work, parts,
                             options.num_subdomains);
}

/// All ranks classify the same boundary on the same model, each for itself.
std::shared_ptr<Geometry> build_geometry(WholeBoundary& boundary, const DecompositionOptions& options) {
  meshing::ModelClassification on_model;
  if (options.model) on_model = meshing::classify_on_model(boundary.data, options.model);
  boundary.warnings.insert(boundary.warnings.end(), on_model.warnings.begin(), on_model.warnings.end());
  meshing::Surface surface(boundary.data, {options.ridge_angle_degrees}, std::move(on_model));
  std::vector<bool> required(surface.patches().size(), false);
  for (const std::uint32_t t : boundary.data.required_triangles)
    required[surface.triangle_patch(t).value] = true;
  std::vector<bool> inner(surface.patches().size(), false);
  return std::make_shared<Geometry>(Geometry{std::move(surface), std::move(required), std::move(inner)});
}

/// Inner patches have two tets at every triangle. Patches are cut at features, so they are all inner or all
/// outer.
void find_inner_patches(Peers& peers, const WholeBoundary& boundary, std::span<const SubdomainStart> starts,
                        Geometry& geometry) {
  std::vector<std::int64_t> faces(geometry.patch_inner.size(), 0), triangles(faces.size(), 0);
  for (const SubdomainStart& s : starts)
    for (const auto& face : s.boundary_faces) ++faces[face.patch.value];
  for (std::uint32_t t = 0; t < boundary.data.triangles.size(); ++t)
    ++triangles[geometry.surface.triangle_patch(t).value];
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
  for (SubdomainStart& s : starts)
    for (const auto& t : s.tets)
      if (is_delicate({s.points[t[0]], s.points[t[1]], s.points[t[2]], s.points[t[3]]}))
        for (const std::uint32_t v : t) s.flags[v] |= kDelicate;
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
  const Ranges points(peers, slice.points.size()), tets(peers, slice.tets.size());
  check_slices(peers, slice, points, tets);
  Distributed result;
  PlacedTets placed = partition::placed(slice.tets);
  Measured measured = check_and_measure(peers, slice, points, placed);
  TetMeasures& measures = measured.tets;
  result.mean_quality = ordered_sum(peers, measures.qualities) / static_cast<double>(slice.num_tets);
  result.complexity = scale_metric(peers, options.target_complexity, slice, measures);
  WholeBoundary boundary = complete_boundary(peers, slice, placed, points, tets);
  placed = {};
  slice.boundary = {};
  result.box = measured.box;
  const std::uint32_t parts =
      options.parts_at_first
          ? options.parts_at_first({slice.num_tets, result.complexity, result.mean_quality})
          : options.num_subdomains;
  Decomposition decomposition = decompose_slice(peers, slice, points, measures, options, parts);
  result.seeds = std::move(decomposition.seeds);
  measures = {};

  const std::vector<TetRecord> mine =
      send_tets_home(peers, slice, std::exchange(decomposition.subdomains, {}), options.num_subdomains);
  const std::vector<PointRecord> records = fetch_points(peers, slice, points, vertices_of(mine));
  slice.points = {};
  slice.point_refs = {};
  slice.log_metrics = {};
  const Holders holders = find_holders(peers, mine, options.num_subdomains);
  const std::shared_ptr<Geometry> geometry = build_geometry(boundary, options);
  result.geometry = geometry;
  const BoundaryIndex index(boundary, *geometry);
  auto begin = mine.begin();
  for (SubdomainId s(0); s.value < options.num_subdomains; ++s.value) {
    if (home_rank(s, options.num_subdomains, peers.ranks()) != peers.rank()) continue;
    const auto end = std::find_if(begin, mine.end(), [&](const TetRecord& t) { return t.subdomain != s; });
    result.starts.push_back(build_start(s, {begin, end}, records, holders, index));
    begin = end;
  }
  find_inner_patches(peers, boundary, result.starts, *geometry);
  mark_delicate(peers, result.starts);
  result.warnings = std::move(boundary.warnings);
  if (!decomposition.warning.empty()) result.warnings.push_back(decomposition.warning);
  if (holders.used < slice.num_points)
    result.warnings.push_back(
        fmt::format("{} points that belong to no tet were dropped", slice.num_points - holders.used));
  return result;
}

}  // namespace weft::partition
