// The least-squares systems of quadratic fits, by Householder QR.
#include "meshing/metric/sources/quadratic_fit.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace weft::meshing {
namespace {

constexpr Eigen::Index kUnknowns = 9;  // six second derivatives, then three first
/// Smallest ratio of the last to the first pivot of a safe fit. No vertex of the meshes it was tried on (the
/// adapted delta wing and cube, boxes of two cells and more in every direction) needs more than two edges for
/// it.
constexpr double kSafePivotRatio = 0.01;
/// Smaller pivots are taken for zero in a fit of least norm.
constexpr double kZeroPivotRatio = 1e-4;

/// Of a squared distance where the mean is 3: keeps points on top of the centre from weighing infinitely.
constexpr double kLeastSquare = 1e-12;

using System = Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

/// Axes in which the points spread equally far: coordinate i of an offset is dot(vectors[i], offset).
std::array<Vec, 3> scaled_axes(const std::vector<Vec>& offsets) {
  SymTensor moment;
  for (const Vec& d : offsets)
    moment = moment + SymTensor{d.x * d.x, d.x * d.y, d.y * d.y, d.x * d.z, d.y * d.z, d.z * d.z};
  const Eigen3 e = eigen_decomposition((1.0 / static_cast<double>(offsets.size())) * moment);
  // Points in one plane spread by rounding only across it; a scale of their own would make noise of that.
  const double least = std::max(e.values[2] * 1e-26, std::numeric_limits<double>::min());
  std::array<Vec, 3> axes;
  for (int i = 0; i < 3; ++i) axes[i] = (1 / std::sqrt(std::max(e.values[i], least))) * e.vectors[i];
  return axes;
}

/// sum_ij h_ij a_i a_j^T for h in the order of the unknowns: 11 12 22 13 23 33.
SymTensor to_space(const Unknowns& h, const std::array<Vec, 3>& axes) {
  const SymTensor local{h[0], h[1], h[2], h[3], h[4], h[5]};
  // Rows of the result are sums over i of a_i times (local . (components of the axes)).
  const Vec x{axes[0].x, axes[1].x, axes[2].x}, y{axes[0].y, axes[1].y, axes[2].y},
      z{axes[0].z, axes[1].z, axes[2].z};
  const Vec lx = apply(local, x), ly = apply(local, y), lz = apply(local, z);
  return {dot(x, lx), dot(x, ly), dot(y, ly), dot(x, lz), dot(y, lz), dot(z, lz)};
}

}  // namespace

struct QuadraticFit::Impl {
  std::vector<Vec> offsets;
  std::vector<double> differences;
  std::array<Vec, 3> axes;
  System system;
  Eigen::VectorXd right_side;
  Eigen::ColPivHouseholderQR<System> qr;

  void assemble() {
    axes = scaled_axes(offsets);
    const auto rows = static_cast<Eigen::Index>(offsets.size());
    system.resize(rows, kUnknowns);
    right_side = Eigen::Map<const Eigen::VectorXd>(differences.data(), rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const Vec& d = offsets[static_cast<std::size_t>(r)];
      const double x = dot(axes[0], d), y = dot(axes[1], d), z = dot(axes[2], d);
      // Near points count more, as the cubic rest of the field there is smaller.
      const double weight = 1 / std::max(x * x + y * y + z * z, kLeastSquare);
      system.row(r) << 0.5 * x * x, x * y, 0.5 * y * y, x * z, y * z, 0.5 * z * z, x, y, z;
      system.row(r) *= weight;
      right_side[r] *= weight;
    }
  }
};

QuadraticFit::QuadraticFit() : impl_(std::make_unique<Impl>()) {}
QuadraticFit::~QuadraticFit() = default;

void QuadraticFit::clear() {
  impl_->offsets.clear();
  impl_->differences.clear();
}

void QuadraticFit::add(const Vec& offset, double difference) {
  impl_->offsets.push_back(offset);
  impl_->differences.push_back(difference);
}

std::optional<SymTensor> QuadraticFit::hessian() {
  if (impl_->offsets.size() < kUnknowns) return std::nullopt;
  impl_->assemble();
  impl_->qr.compute(impl_->system);
  const auto& r = impl_->qr.matrixR();
  if (!(std::abs(r(kUnknowns - 1, kUnknowns - 1)) > kSafePivotRatio * std::abs(r(0, 0)))) return std::nullopt;
  const Unknowns solution = impl_->qr.solve(impl_->right_side);
  return to_space(solution, impl_->axes);
}

SymTensor QuadraticFit::least_norm_hessian() {
  if (impl_->offsets.empty()) return {};
  impl_->assemble();
  Eigen::CompleteOrthogonalDecomposition<System> decomposition;
  decomposition.setThreshold(kZeroPivotRatio);
  decomposition.compute(impl_->system);
  const Unknowns solution = decomposition.solve(impl_->right_side);
  return to_space(solution, impl_->axes);
}

}  // namespace weft::meshing
