// Closed formulas of the corners and the mean metric.
#include "partition/decompose/tet_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "meshing/mesh/tet_tables.h"
#include "meshing/metric/expectations.h"

namespace weft::partition {
namespace {

using meshing::LogMetric;
using meshing::Point;
using meshing::SymTensor;
using meshing::Vec;

/// The inverse of the metric in which the tet is equilateral, up to a factor: its corners' second moments.
SymTensor implied_inverse(const TetCorners& tet) {
  const Point centre = 0.25 * (tet[0] + tet[1] + (tet[2] + tet[3]));
  SymTensor sum;
  for (const Point& p : tet) {
    const Vec d = p - centre;
    sum = sum + SymTensor{d.x * d.x, d.x * d.y, d.y * d.y, d.x * d.z, d.y * d.z, d.z * d.z};
  }
  return sum;
}

/// tr(A B^-1).
double trace_of_quotient(const SymTensor& a, const SymTensor& b) {
  const double yy_zz = b.yy * b.zz - b.yz * b.yz, xx_zz = b.xx * b.zz - b.xz * b.xz,
               xx_yy = b.xx * b.yy - b.xy * b.xy, xy = b.xz * b.yz - b.xy * b.zz,
               xz = b.xy * b.yz - b.xz * b.yy, yz = b.xy * b.xz - b.yz * b.xx;
  return (a.xx * yy_zz + a.yy * xx_zz + a.zz * xx_yy + 2 * (a.xy * xy + a.xz * xz + a.yz * yz)) /
         determinant(b);
}

/// The divided difference of exp over N places within [-1/2, 1/2]: the sum of h_k / (N - 1 + k)!, h_k the
/// complete homogeneous polynomial.
template <std::size_t N>
double close_difference(const std::array<double, N>& x) {
  constexpr std::size_t kTerms = 10;
  std::array<double, kTerms> h{1};
  for (const double y : x)
    for (std::size_t k = 1; k < kTerms; ++k) h[k] += y * h[k - 1];
  double factor = 1, sum = 0;
  for (std::size_t n = 2; n < N; ++n) factor /= static_cast<double>(n);
  for (std::size_t k = 0; k < kTerms; ++k) {
    sum += factor * h[k];
    factor /= static_cast<double>(N + k);
  }
  return sum;
}

/// The divided difference of exp over places in ascending order.
template <std::size_t N>
double difference_of_exp(std::span<const double, N> x) {
  if constexpr (N == 1) {
    return std::exp(x[0]);
  } else {
    const double reach = x.back() - x.front();
    if (reach > 1)
      return (difference_of_exp(x.template last<N - 1>()) - difference_of_exp(x.template first<N - 1>())) /
             reach;
    const double middle = 0.5 * (x.front() + x.back());
    std::array<double, N> around;
    for (std::size_t i = 0; i < N; ++i) around[i] = x[i] - middle;
    return std::exp(middle) * close_difference(around);
  }
}

/// A tet that is exactly positive may compute a negative volume.
double usable_volume(const TetCorners& p) { return std::max(0.0, six_volume(p[0], p[1], p[2], p[3]) / 6); }

}  // namespace

double density(const LogMetric& log_metric) { return std::exp(0.5 * trace(log_metric)); }

double complexity(const TetCorners& p, const std::array<double, 4>& densities) {
  double density = 0;
  for (const double d : densities) density += 0.25 * d;
  return std::min(usable_volume(p) * density, std::numeric_limits<double>::max());
}

double mean_of_exp(std::array<double, 4> x) {
  std::ranges::sort(x);
  const double top = x.back();  // what is left of exp is at most 1: differences do not overflow
  for (double& place : x) place -= top;
  return std::min(std::exp(top) * 6 * difference_of_exp(std::span<const double, 4>(x)),
                  std::numeric_limits<double>::max());
}

double expected_complexity(const TetCorners& p, const std::array<LogMetric, 4>& log_metrics) {
  std::array<double, 4> log_densities;
  for (std::size_t i = 0; i < 4; ++i) log_densities[i] = 0.5 * trace(log_metrics[i]);
  return std::min(usable_volume(p) * mean_of_exp(log_densities), std::numeric_limits<double>::max());
}

SymTensor unit_inverse(const LogMetric& log_metric) {
  return meshing::exp_fast(meshing::identity_tensor(trace(log_metric) / 3) - log_metric);
}

std::array<float, 4> face_areas(const TetCorners& tet, const SymTensor& inverse, double scale) {
  // Of a face with normal n (its area long): sqrt(det M n.M^-1.n), and M^-1 = S / det(M)^(1/3).
  std::array<float, 4> areas;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& f = meshing::kTetFaces[i];
    const Vec normal = 0.5 * cross(tet[f[1]] - tet[f[0]], tet[f[2]] - tet[f[0]]);
    areas[i] = static_cast<float>(scale * std::sqrt(std::max(0.0, squared_length(inverse, normal))));
  }
  return areas;
}

double vertices_wanted(float area, float other_area) {
  constexpr double kUnitTriangle = 0.4330127018922193;  // sqrt(3)/4
  const auto usable = [](float a) {
    return a > 0 ? std::min<double>(a, std::numeric_limits<float>::max()) : 0;
  };
  return 0.5 * (usable(area) + usable(other_area)) / (2 * kUnitTriangle);
}

SymTensor cut_tensor(const TetCorners& tet, const SymTensor& inverse) {
  const auto usable = [](const SymTensor& t) { return trace(t) > 0 && std::isfinite(trace(t)); };
  const SymTensor implied = implied_inverse(tet);
  if (!usable(inverse)) return meshing::identity_tensor();
  const SymTensor isotropic = 0.5 * trace_of_quotient(inverse, implied) * implied;
  return usable(isotropic) ? inverse + isotropic : inverse;
}

void TetMeasures::reserve(std::size_t tets) {
  centres.reserve(tets);
  corners.reserve(tets);
  complexities.reserve(tets);
  cut_tensors.reserve(tets);
  face_areas.reserve(tets);
}

void TetMeasures::add(const TetCorners& p, const std::array<LogMetric, 4>& log_metrics, double complexity) {
  complexities.push_back(complexity);
  LogMetric mean;
  for (const LogMetric& l : log_metrics) mean = mean + 0.25 * l;
  const SymTensor inverse = unit_inverse(mean);
  cut_tensors.push_back(cut_tensor(p, inverse));
  face_areas.push_back(partition::face_areas(p, inverse, std::exp(trace(mean) / 3)));
  corners.push_back(p);
  centres.push_back(0.25 * (p[0] + p[1] + (p[2] + p[3])));
}

void TetMeasures::scale(double factor) {
  for (double& c : complexities) c *= factor;
  const auto area_factor = static_cast<float>(std::pow(factor, 2.0 / 3));
  for (auto& areas : face_areas)
    for (float& area : areas) area *= area_factor;
}

std::vector<double> work_of(std::span<const double> expected_complexities) {
  constexpr double kHandling = 0.1;  // of a tet that is there, in final tets
  std::vector<double> all;
  all.reserve(expected_complexities.size());
  for (const double c : expected_complexities) all.push_back(meshing::kTetsPerComplexity * c + kHandling);
  return all;
}

}  // namespace weft::partition
