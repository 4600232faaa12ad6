// Walks by exact orientations, and what to do where the boundary is in the way.
#include "meshing/fields/tet_locator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "meshing/base/box.h"
#include "meshing/base/small_set.h"
#include "meshing/geometry/surface/curved_triangle.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {
namespace {

constexpr unsigned kOutside = 1u << 4;  ///< in place of a set of faces

std::array<Point, 3> face_of(const std::array<Point, 4>& x, std::size_t f) {
  const auto& [i, j, k] = kTetFaces[f];
  return {x[static_cast<std::size_t>(i)], x[static_cast<std::size_t>(j)], x[static_cast<std::size_t>(k)]};
}

/// The weights of a tet's corners from those of its face.
std::array<double, 4> in_tet(const std::array<double, 3>& at, std::size_t f) {
  std::array<double, 4> weights{};
  for (std::size_t i = 0; i < 3; ++i) weights[static_cast<std::size_t>(kTetFaces[f][i])] = at[i];
  return weights;
}

/// The face that is closest to a point, and where.
struct OnFaces {
  std::size_t face = 0;
  TrianglePoint closest;
};
OnFaces closest_face(const std::array<Point, 4>& x, const Point& p) {
  OnFaces result;
  result.closest.distance2 = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < 4; ++f) {
    const auto [a, b, c] = face_of(x, f);
    const TrianglePoint q = closest_point(a, b, c, p);
    if (q.distance2 < result.closest.distance2) result = {f, q};
  }
  return result;
}

}  // namespace

TetLocator::TetLocator(const MeshData& mesh, Adjacency adjacency,
                       const std::function<bool(std::uint32_t)>& may_be_cut)
    : mesh_(mesh), adjacency_(std::move(adjacency)) {
  std::vector<ClosestForest::Item> border, boundary;
  for (std::uint32_t t = 0; t < mesh_.tets.size(); ++t)
    for (std::uint32_t f = 0; f < 4; ++f) {
      if (adjacency_.neighbours[t][f] != kNoNeighbour) continue;
      border.push_back({box_of(corners_of_face(4 * t + f)), 4 * t + f});
      const auto at = [&](int i) { return mesh_.tets[t][static_cast<std::size_t>(i)]; };
      if (may_be_cut && !std::ranges::all_of(kTetFaces[f], [&](int i) { return may_be_cut(at(i)); }))
        boundary.push_back(border.back());
    }
  border_ = faces_.add(border);
  if (!may_be_cut) boundary_ = border_;
  if (!boundary.empty()) boundary_ = faces_.add(boundary);
}

std::array<Point, 4> TetLocator::corners_of(std::uint32_t tet) const {
  const auto& [a, b, c, d] = mesh_.tets[tet];
  return {mesh_.points[a], mesh_.points[b], mesh_.points[c], mesh_.points[d]};
}

std::array<Point, 3> TetLocator::corners_of_face(std::uint32_t face) const {
  return face_of(corners_of(face >> 2), face & 3);
}

/// The tet's faces on which `p` is exactly, by their bits, or kOutside.
unsigned TetLocator::faces_with(std::uint32_t tet, const Point& p) const {
  const std::array<Point, 4> x = corners_of(tet);
  unsigned faces = 0;
  for (std::size_t f = 0; f < 4; ++f) {
    const auto [a, b, c] = face_of(x, f);
    const int side = orientation(a, b, c, p);
    if (side < 0) return kOutside;
    if (side == 0) faces |= 1u << f;
  }
  return faces;
}

/// Of large tets weights are computed best.
bool TetLocator::comes_before(std::uint32_t a, std::uint32_t b) const {
  const auto volume = [&](std::uint32_t t) {
    const auto [x0, x1, x2, x3] = corners_of(t);
    return six_volume(x0, x1, x2, x3);
  };
  const double of_a = volume(a), of_b = volume(b);
  return of_a != of_b ? of_a > of_b : mesh_.tets[a] < mesh_.tets[b];
}

/// True where it ends in a tet that holds `p`; else the boundary was in the way.
bool TetLocator::walk(const Point& p, std::uint32_t& tet) const {
  constexpr int kMaxSteps = 1000000;
  constexpr std::uint32_t kNowhere = 4;
  std::uint32_t entered = kNowhere, random = 12345;
  for (int step = 0; step < kMaxSteps; ++step) {
    const std::array<Point, 4> x = corners_of(tet);
    random = random * 1664525u + 1013904223u;  // a random order of faces keeps the walk from cycling
    bool outside = false;
    std::uint32_t way = kNoNeighbour;
    for (std::uint32_t i = 0; i < 4 && way == kNoNeighbour; ++i) {
      const std::uint32_t f = (i + (random >> 30)) & 3;
      if (f == entered) continue;
      const auto [a, b, c] = face_of(x, f);
      if (orientation(a, b, c, p) >= 0) continue;
      outside = true;
      way = adjacency_.neighbours[tet][f];
    }
    if (!outside) return true;
    if (way == kNoNeighbour) return false;
    tet = way >> 2;
    entered = way & 3;
  }
  return false;
}

/// On the faces of a tree. A distance is not taken as less than that of the face's box, so that the
/// tree leaves out nothing by rounding.
TetLocator::BoundaryPoint TetLocator::closest(const Point& p, std::uint32_t root) const {
  BoundaryPoint best;
  best.distance2 = std::numeric_limits<double>::infinity();
  faces_.visit_within(root, p, best.distance2, [&](std::uint32_t face) {
    const std::array<Point, 3> x = corners_of_face(face);
    const TrianglePoint q = closest_point(x[0], x[1], x[2], p);
    const double distance2 = std::max(q.distance2, box_of(x).distance2(p));
    if (distance2 > best.distance2) return;
    const std::uint32_t tet = face >> 2, other = best.face >> 2;
    if (distance2 == best.distance2 && best.face != kNoHint &&
        (tet == other ? face > best.face : comes_before(other, tet)))
      return;
    best = {face, q.at, distance2};
  });
  return best;
}

/// A tet that holds `p`, or kNoHint. All that is nearer to a point inside than the boundary is inside too, so
/// that its tet is reached from there through tets that are no farther off; about a point outside there are
/// few of them. Two sides of a slit, or bodies that touch and are not joined, have boundary equally near: the
/// search begins at all of it.
std::uint32_t TetLocator::holder_near(const Point& p, const BoundaryPoint& closest) const {
  constexpr double kFarther = 1 + 1e-6, kRounding = 1e-9;
  const double limit = kFarther * std::sqrt(closest.distance2) +
                       kRounding * norm(box_of(corners_of_face(closest.face)).size());
  SmallSet seen;
  std::vector<std::uint32_t> pending;
  std::uint32_t holder = kNoHint;
  const auto look_at = [&](std::uint32_t tet) {
    if (holder != kNoHint || !seen.insert(tet)) return;
    if (faces_with(tet, p) != kOutside)
      holder = tet;
    else if (closest_face(corners_of(tet), p).closest.distance2 <= limit * limit)
      pending.push_back(tet);
  };
  faces_.visit_within(border_, p, limit * limit, [&](std::uint32_t face) { look_at(face >> 2); });
  while (holder == kNoHint && !pending.empty()) {
    const std::uint32_t tet = pending.back();
    pending.pop_back();
    for (const std::uint32_t code : adjacency_.neighbours[tet])
      if (code != kNoNeighbour) look_at(code >> 2);
  }
  return holder;
}

/// All tets that hold `p`, which `tet` does: what is joined to it by faces with `p`, and where these end at
/// the boundary what only touches it.
std::vector<std::uint32_t> TetLocator::holders_from(std::uint32_t tet, const Point& p) const {
  std::vector<std::uint32_t> holders;
  SmallSet seen;
  const auto add = [&](std::uint32_t t) {
    if (seen.insert(t)) holders.push_back(t);
  };
  add(tet);
  bool at_boundary = false;
  for (std::size_t i = 0; i < holders.size(); ++i) {
    const unsigned faces = faces_with(holders[i], p);
    for (std::size_t f = 0; f < 4; ++f) {
      if ((faces >> f & 1) == 0) continue;
      const std::uint32_t code = adjacency_.neighbours[holders[i]][f];
      if (code != kNoNeighbour) {
        add(code >> 2);
      } else if (!std::exchange(at_boundary, true)) {
        faces_.visit_within(border_, p, 0, [&](std::uint32_t face) {
          if (faces_with(face >> 2, p) != kOutside) add(face >> 2);
        });
      }
    }
  }
  return holders;
}

/// In a tet that is all but flat rounding would leave nothing of the weights: those on its closest face.
TetLocator::Place TetLocator::place_in(std::uint32_t tet, const Point& p) const {
  constexpr double kFlat = 1e-12;
  const std::array<Point, 4> x = corners_of(tet);
  const Vec u = x[1] - x[0], v = x[2] - x[0], w = x[3] - x[0], q = p - x[0];
  const Vec vw = cross(v, w), uq = cross(u, q);
  const double det = dot(u, vw);
  if (!(det > kFlat * norm(u) * norm(v) * norm(w))) {
    const OnFaces on = closest_face(x, p);
    return {tet, in_tet(on.closest.at, on.face), 0, true};
  }
  std::array<double, 4> l{0, dot(q, vw) / det, dot(uq, w) / det, -dot(uq, v) / det};
  l[0] = 1 - l[1] - l[2] - l[3];
  double sum = 0;
  for (double& weight : l) sum += weight = std::max(weight, 0.0);
  for (double& weight : l) weight /= sum;
  return {tet, l, 0, true};
}

TetLocator::Place TetLocator::beyond(const Point& p, const BoundaryPoint& border) const {
  if (!boundary_) return {border.face >> 2, {}, std::numeric_limits<double>::infinity(), false};
  const BoundaryPoint on = *boundary_ == border_ ? border : closest(p, *boundary_);
  return {on.face >> 2, in_tet(on.at, on.face & 3), on.distance2, false, on.face & 3};
}

TetLocator::Place TetLocator::locate(const Point& p, std::uint32_t hint) const {
  std::uint32_t tet = hint == kNoHint ? 0 : hint;
  if (!walk(p, tet)) {
    const BoundaryPoint border = closest(p, border_);
    tet = border.face >> 2;
    if (!walk(p, tet)) tet = holder_near(p, border);
    if (tet == kNoHint) return beyond(p, border);
  }
  if (faces_with(tet, p) == 0) return place_in(tet, p);
  const std::vector<std::uint32_t> holders = holders_from(tet, p);
  const auto first = [&](std::uint32_t a, std::uint32_t b) { return comes_before(a, b); };
  return place_in(*std::ranges::min_element(holders, first), p);
}

}  // namespace weft::meshing
