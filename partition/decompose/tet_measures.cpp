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

}  // namespace

double density(const LogMetric& log_metric) { return std::exp(0.5 * trace(log_metric)); }

double complexity(const TetCorners& p, const std::array<double, 4>& densities) {
  double density = 0;
  for (const double d : densities) density += 0.25 * d;
  // A tet that is exactly positive may compute a negative volume.
  const double volume = std::max(0.0, six_volume(p[0], p[1], p[2], p[3]) / 6);
  return std::min(volume * density, std::numeric_limits<double>::max());
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

void TetMeasures::add(const TetCorners& p, const std::array<LogMetric, 4>& log_metrics) {
  std::array<double, 4> densities;
  for (std::size_t i = 0; i < 4; ++i) densities[i] = density(log_metrics[i]);
  complexities.push_back(complexity(p, densities));
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

std::vector<double> work_of(std::span<const double> complexities) {
  constexpr double kHandling = 0.1;  // of a tet that is there, in final tets
  std::vector<double> all;
  all.reserve(complexities.size());
  for (const double c : complexities) all.push_back(meshing::kTetsPerComplexity * c + kHandling);
  return all;
}

}  // namespace weft::partition
