// Fits slope and curvature to a vertex's neighbours by damped least squares.
#include "meshing/geometry/surface/normal_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace weft::meshing {
namespace {

constexpr int kFits = 4;
constexpr double kHoldBack = 1e-4;
// Sum of the slopes' variances, for unit variance of the slopes from the vertex to its neighbours, above
// which a fit is extrapolation. Measured on irregular cylinders and cones: at 3 good fits are lost, at 30 bad
// ones get in.
constexpr double kUncertain = 10;

/// Symmetric positive definite 5x5 system by Cholesky's factors; only the lower half is read.
class System {
 public:
  /// False where the matrix is not positive definite.
  bool factor() {
    for (int j = 0; j < 5; ++j) {
      for (int k = 0; k < j; ++k) m_[j][j] -= m_[j][k] * m_[j][k];
      if (!(m_[j][j] > 0)) return false;
      m_[j][j] = std::sqrt(m_[j][j]);
      for (int i = j + 1; i < 5; ++i) {
        for (int k = 0; k < j; ++k) m_[i][j] -= m_[i][k] * m_[j][k];
        m_[i][j] /= m_[j][j];
      }
    }
    return true;
  }
  std::array<double, 5> solve(std::array<double, 5> x) const {
    for (int i = 0; i < 5; ++i) {
      for (int k = 0; k < i; ++k) x[i] -= m_[i][k] * x[k];
      x[i] /= m_[i][i];
    }
    for (int i = 4; i >= 0; --i) {
      for (int k = i + 1; k < 5; ++k) x[i] -= m_[k][i] * x[k];
      x[i] /= m_[i][i];
    }
    return x;
  }
  void add(const std::array<double, 5>& row) {
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j <= i; ++j) m_[i][j] += row[i] * row[j];
    }
  }
  void hold_back(double share) {
    for (int i = 0; i < 5; ++i) m_[i][i] *= 1 + share;
  }

 private:
  std::array<std::array<double, 5>, 5> m_{};
};

/// The surface about a vertex as height over a plane: h = a u + b v + (c u^2 + 2 d u v + e v^2 + k h^2) / 2,
/// where k, the larger principal curvature, makes spheres and cylinders fit without residue.
struct LocalFit {
  Vec normal;  ///< of the plane
  double c = 0, d = 0, e = 0;
  double variance = 0;  ///< of the normal, as the residue of the last step tells

  double larger_curvature() const {
    const double mean = 0.5 * (c + e), spread = std::hypot(0.5 * (c - e), d);
    return mean >= 0 ? mean + spread : mean - spread;
  }
};

/// One Gauss-Newton step of least squares over the points of `ring` (in units of `size`) and the known
/// `tangents`. The damping only keeps the system regular. False where the points do not determine the normal,
/// as often for a vertex at a feature edge with a single row of triangles.
bool improve(LocalFit& fit, std::span<const Vec> ring, std::span<const Vec> tangents, double size) {
  const Vec side = std::abs(fit.normal.x) < 0.6 ? Vec{1, 0, 0} : Vec{0, 1, 0};
  const Vec e1 = normalized(cross(fit.normal, side)), e2 = cross(fit.normal, e1);
  const double k = fit.larger_curvature();
  System system;
  std::array<double, 5> x{};
  double residue2 = 0;
  int rows = 0;
  const auto add = [&](const std::array<double, 5>& row, double residue) {
    for (int i = 0; i < 5; ++i) x[i] += row[i] * residue;
    system.add(row);
    residue2 += residue * residue;
    ++rows;
  };
  for (const Vec& point : ring) {
    const double u = dot(point, e1) / size, v = dot(point, e2) / size, h = dot(point, fit.normal) / size;
    const double rho = std::sqrt(u * u + v * v + h * h);
    if (!(rho > 0)) continue;
    const double model = 0.5 * (fit.c * u * u + 2 * fit.d * u * v + fit.e * v * v + k * h * h);
    add({u / rho, v / rho, 0.5 * u * u / rho, u * v / rho, 0.5 * v * v / rho}, (h - model) / rho);
  }
  for (const Vec& t : tangents) add({dot(t, e1), dot(t, e2), 0, 0, 0}, dot(t, fit.normal));
  system.hold_back(kHoldBack);
  if (!system.factor()) return false;
  const double variance = system.solve({1, 0, 0, 0, 0})[0] + system.solve({0, 1, 0, 0, 0})[1];
  if (variance > kUncertain) return false;
  fit.variance = variance * residue2 / std::max(1, rows - 5);
  x = system.solve(x);
  fit.normal = normalized(fit.normal - x[0] * e1 - x[1] * e2);
  fit.c += x[2], fit.d += x[3], fit.e += x[4];
  return true;
}

}  // namespace

Vec improved_normal(std::span<const Vec> ring, std::span<const Vec> tangents, const Vec& mean) {
  double size2 = 0;
  for (const Vec& d : ring) size2 += norm2(d) / static_cast<double>(ring.size());
  if (!(size2 > 0)) return mean;
  LocalFit fit{mean};
  for (int i = 0; i < kFits; ++i) {
    const Vec before = fit.normal;
    if (!improve(fit, ring, tangents, std::sqrt(size2))) return mean;
    if (norm2(fit.normal - before) < 1e-20) break;
  }
  const Vec correction = fit.normal - mean;
  const double sum = norm2(correction) + fit.variance;
  if (!(sum > 0) || dot(fit.normal, mean) < kTrustedCosine) return mean;
  return normalized(mean + norm2(correction) / sum * correction);
}

}  // namespace weft::meshing
