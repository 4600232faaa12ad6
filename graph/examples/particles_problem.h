// Particles in a periodic square that repel each other over a short distance, most of them in a cloud that
// drifts: cells of one size have very different work, and not the same for long.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace weft::examples::particles {

struct Particle {
  std::int64_t id = 0;
  double x = 0, y = 0;
};
using Particles = std::vector<Particle>;

constexpr double kDrift = 0.01;         ///< of all, in x, a step
constexpr double kForce = 1e-5;         ///< of a pair at no distance, a step
constexpr double kSecondsAPair = 2e-9;  ///< a guess, for the balancer

inline double wrapped(double x) { return x - std::floor(x); }

/// Quasi-random: dense at the centre of a cloud.
inline Particle first(std::int64_t id) {
  const double u = wrapped(static_cast<double>(id) * 0.6180339887498949);
  const double angle = 2 * std::numbers::pi * wrapped(static_cast<double>(id) * 0.7548776662466927);
  const double radius = 0.45 * u * u;
  return {id, wrapped(0.3 + radius * std::cos(angle)), wrapped(0.3 + radius * std::sin(angle))};
}

/// side x side cells, whose side is as far as a force reaches.
struct Cells {
  int side = 0;

  int of(double x) const { return std::min(static_cast<int>(x * side), side - 1); }
  int cell(const Particle& particle) const { return of(particle.y) * side + of(particle.x); }
  /// The cell and the eight around it, in an order that is the same on all ranks.
  std::array<int, 9> around(int cell) const {
    std::array<int, 9> cells{};
    std::size_t n = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        cells[n++] = (cell / side + dy + side) % side * side + (cell % side + dx + side) % side;
    return cells;
  }
};

/// Where each of `own` is a step later; `others` are the particles of the cells around it, each cell's in the
/// order of their ids.
inline Particles moved(const Particles& own, std::span<const std::span<const Particle>> others,
                       double reach) {
  Particles result = own;
  for (Particle& p : result) {
    double fx = 0, fy = 0;
    const Particle at = p;
    for (const auto& cell : others)
      for (const Particle& q : cell) {
        double dx = at.x - q.x, dy = at.y - q.y;
        dx -= std::nearbyint(dx);
        dy -= std::nearbyint(dy);
        const double distance = std::sqrt(dx * dx + dy * dy);
        if (distance >= reach || q.id == at.id) continue;
        const double strength = kForce * (1 - distance / reach) / std::max(distance, 1e-9);
        fx += strength * dx;
        fy += strength * dy;
      }
    p.x = wrapped(at.x + kDrift + fx);
    p.y = wrapped(at.y + fy);
  }
  return result;
}

inline void sort_by_id(Particles& particles) {
  std::sort(particles.begin(), particles.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
}

}  // namespace weft::examples::particles
