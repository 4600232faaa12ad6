// The steps of the distribution, in their order.
#include "partition/distribute/distribute.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include "meshing/kernel/quality.h"
#include "meshing/metric/expectations.h"
#include "partition/communication/home_rank.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/communication/same_arithmetic.h"
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

/// What handling an input tet costs, in final tets.
constexpr double kHandling = 0.1;

/// The slice's tets with the points that they need from anywhere.
class TetPoints {
 public:
  TetPoints(Peers& peers, const MeshSlice& slice, const Ranges& ranges) : tets_(slice.tets) {
    for (const auto& tet : tets_) numbers_.insert(numbers_.end(), tet.begin(), tet.end());
    std::sort(numbers_.begin(), numbers_.end());
    numbers_.erase(std::unique(numbers_.begin(), numbers_.end()), numbers_.end());
    records_ = fetch_points(peers, slice, ranges, numbers_);
  }
  std::array<const PointRecord*, 4> of(std::size_t t) const {
    std::array<const PointRecord*, 4> result;
    for (std::size_t i = 0; i < 4; ++i)
      result[i] = &records_[static_cast<std::size_t>(
          std::lower_bound(numbers_.begin(), numbers_.end(), tets_[t][i]) - numbers_.begin())];
    return result;
  }
  const std::vector<PointRecord>& all() const { return records_; }

 private:
  std::span<const std::array<std::uint32_t, 4>> tets_;
  std::vector<std::uint32_t> numbers_;
  std::vector<PointRecord> records_;
};

/// What the decomposition wants to know of the slice's tets.
struct TetMeasures {
  std::vector<Point> centres;
  std::vector<TetCorners> corners;
  std::vector<double> complexities;
  std::vector<double> qualities;
  std::vector<meshing::SymTensor> cut_tensors;   ///< Items::cut_tensors
  std::vector<std::array<float, 4>> face_areas;  ///< Items::face_areas
  meshing::Box box;                              ///< of the whole mesh
};

/// Mean ratio in the metric `log_metric`; it does not change when the metric is scaled.
double quality(const TetCorners& p, const meshing::LogMetric& log_metric) {
  return mean_ratio(six_volume(p[0], p[1], p[2], p[3]), meshing::exp_fast(log_metric),
                    std::exp(trace(log_metric)), p[1] - p[0], p[2] - p[0], p[3] - p[0]);
}

TetMeasures measure_tets(Peers& peers, const MeshSlice& slice, const TetPoints& points) {
  TetMeasures m;
  for (std::size_t t = 0; t < slice.tets.size(); ++t) {
    const auto p = points.of(t);
    double density = 0;  // sqrt(det M) = exp(trace(log M) / 2)
    for (const PointRecord* corner : p) density += 0.25 * std::exp(0.5 * trace(corner->log_metric));
    // A tet that is exactly positive may compute a negative volume.
    const double volume = std::max(0.0, six_volume(p[0]->point, p[1]->point, p[2]->point, p[3]->point) / 6);
    m.complexities.push_back(std::min(volume * density, std::numeric_limits<double>::max()));
    meshing::LogMetric mean;
    for (const PointRecord* corner : p) mean = mean + 0.25 * corner->log_metric;
    const TetCorners corners{p[0]->point, p[1]->point, p[2]->point, p[3]->point};
    const meshing::SymTensor inverse = unit_inverse(mean);
    m.cut_tensors.push_back(cut_tensor(corners, inverse));
    m.qualities.push_back(quality(corners, mean));
    m.face_areas.push_back(face_areas(corners, inverse, std::exp(trace(mean) / 3)));
    m.corners.push_back(corners);
    m.centres.push_back(0.25 * (p[0]->point + p[1]->point + (p[2]->point + p[3]->point)));
  }
  std::vector<Point> all;
  for (const PointRecord& record : points.all()) all.push_back(record.point);
  m.box = group_boxes(peers, all, std::vector<std::uint32_t>(all.size(), 0), 1)[0];
  return m;
}

TetMeasures check_and_measure(Peers& peers, const MeshSlice& slice, const Ranges& ranges) {
  const TetPoints points(peers, slice, ranges);
  std::vector<std::array<const Point*, 4>> corners;
  for (std::size_t t = 0; t < slice.tets.size(); ++t) {
    const auto p = points.of(t);
    corners.push_back({&p[0]->point, &p[1]->point, &p[2]->point, &p[3]->point});
  }
  throw_first(peers, find_inverted(slice, corners));
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
  for (double& c : measures.complexities) c *= factor;
  const auto area_factor = static_cast<float>(std::pow(factor, 2.0 / 3));
  for (auto& areas : measures.face_areas)
    for (float& area : areas) area *= area_factor;
  return target;
}

Decomposition decompose_slice(Peers& peers, const MeshSlice& slice, const TetMeasures& measures,
                              const DecompositionOptions& options) {
  std::vector<double> work;
  std::vector<std::uint64_t> numbers;
  for (std::size_t t = 0; t < slice.tets.size(); ++t) {
    work.push_back(options.equal_tets ? 1
                                      : meshing::kTetsPerComplexity * measures.complexities[t] + kHandling);
    numbers.push_back(slice.first_tet + t);
  }
  return decompose(peers,
                   {measures.centres, measures.corners, work, numbers, measures.cut_tensors, slice.tets,
                    measures.face_areas, measures.complexities},
                   options.num_subdomains, options.partitioner);
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
  TetMeasures measures = check_and_measure(peers, slice, points);
  result.mean_quality = ordered_sum(peers, measures.qualities) / static_cast<double>(slice.num_tets);
  result.complexity = scale_metric(peers, options.target_complexity, slice, measures);
  WholeBoundary boundary = complete_boundary(peers, slice, points, tets);
  slice.boundary = {};
  result.box = measures.box;
  Decomposition decomposition = decompose_slice(peers, slice, measures, options);
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
