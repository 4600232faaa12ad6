// Point location by walking, and log-Euclidean interpolation.
#include "meshing/background.h"

#include <algorithm>
#include <limits>

#include "meshing/tet_tables.h"

namespace weft::meshing {
namespace {

/// Negative coordinates set to zero and the rest scaled to sum to one: the closest simplex feature, nearly.
std::array<double, 4> clamped(std::array<double, 4> l) {
  double sum = 0;
  for (double& x : l) sum += x = std::max(x, 0.0);
  for (double& x : l) x /= sum;
  return l;
}

}  // namespace

Background::Background(const MeshData& mesh, std::span<const LogMetric> log_metrics)
    : mesh_(mesh), log_metrics_(log_metrics), adjacency_(build_adjacency(mesh.tets, mesh.points.size())),
      vertex_tets_(mesh.points.size(), 0) {
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
    for (std::uint32_t v : mesh.tets[t]) vertex_tets_[v] = t;
}

Background::Barycentric Background::barycentric(std::uint32_t tet, const Point& p) const {
  const auto& v = mesh_.tets[tet];
  const Point &a = mesh_.points[v[0]], &b = mesh_.points[v[1]], &c = mesh_.points[v[2]], &d = mesh_.points[v[3]];
  const Vec u = b - a, w = c - a, z = d - a, q = p - a;
  const Vec wz = cross(w, z), uq = cross(u, q);
  const double inverse = 1 / dot(u, wz);
  Barycentric l;
  l[1] = dot(q, wz) * inverse;
  l[2] = dot(uq, z) * inverse;
  l[3] = -dot(uq, w) * inverse;
  l[0] = 1 - l[1] - l[2] - l[3];
  return l;
}

bool Background::walk(const Point& p, std::uint32_t& tet, Barycentric& l) const {
  // Rounding in flat tets may send the walk round in circles: a slightly outside point ends it.
  constexpr double kTolerance = 1e-10;
  constexpr int kMaxSteps = 1000000;
  std::uint32_t previous = kNoNeighbour;
  std::uint32_t random = 12345;
  for (int step = 0; step < kMaxSteps; ++step) {
    l = barycentric(tet, p);
    int way = -1;
    bool outside = false;
    random = random * 1664525u + 1013904223u;  // a random order of faces keeps the walk from cycling
    double most = -kTolerance;
    for (int i = 0; i < 4; ++i) {
      const int f = (i + static_cast<int>(random >> 30)) & 3;
      if (l[f] >= -kTolerance) continue;
      outside = true;
      const std::uint32_t n = adjacency_.neighbours[tet][f];
      if (n == kNoNeighbour || n >> 2 == previous) continue;
      if (step > 200 ? way < 0 : l[f] < most) {
        way = f;
        most = l[f];
      }
    }
    if (!outside) return true;
    if (way < 0) return false;
    previous = tet;
    tet = adjacency_.neighbours[tet][way] >> 2;
  }
  return false;
}

LogMetric Background::interpolate(std::uint32_t tet, const Barycentric& l) const {
  const auto& v = mesh_.tets[tet];
  return l[0] * log_metrics_[v[0]] + l[1] * log_metrics_[v[1]] + l[2] * log_metrics_[v[2]] + l[3] * log_metrics_[v[3]];
}

bool Background::close_enough(const Point& p, std::uint32_t tet, const Barycentric& l) const {
  const auto& v = mesh_.tets[tet];
  Point nearest;
  for (int i = 0; i < 4; ++i) nearest += l[i] * mesh_.points[v[i]];
  // Within half a unit length the metric hardly changes: no need to look for the other side of a gap.
  return squared_length(exp_fast(interpolate(tet, l)), p - nearest) < 0.25;
}

std::uint32_t Background::search_everywhere(const Point& p) const {
  std::uint32_t best = 0;
  double best_distance = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = 0; t < mesh_.tets.size(); ++t) {
    const Barycentric l = barycentric(t, p);
    const double least = *std::min_element(l.begin(), l.end());
    if (least >= 0) return t;
    if (-least > 1) continue;
    const Barycentric c = clamped(l);
    Point nearest;
    for (int i = 0; i < 4; ++i) nearest += c[i] * mesh_.points[mesh_.tets[t][i]];
    const double distance = norm2(p - nearest);
    if (distance < best_distance) {
      best_distance = distance;
      best = t;
    }
  }
  return best;
}

Background::Sample Background::at(const Point& p, std::uint32_t hint) const {
  std::uint32_t tet = hint == kNoHint ? 0 : hint;
  Barycentric l;
  if (!walk(p, tet, l)) {
    if (!close_enough(p, tet, clamped(l))) {
      tet = search_everywhere(p);
      l = barycentric(tet, p);
    }
  }
  l = clamped(l);
  return {interpolate(tet, l), tet};
}

}  // namespace weft::meshing
