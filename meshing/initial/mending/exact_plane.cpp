// Insertion by splitting, Lawson's flips for shape, Sloan's for segments (1993).
#include "meshing/initial/mending/exact_plane.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace weft::meshing {

PlaneTriangulation::PlaneTriangulation(const Face& corners, const std::array<Point2, 3>& places) {
  for (std::size_t i = 0; i < 3; ++i) {
    place_.emplace(corners[i], places[i]);
    rounded_[corners[i]] = {CGAL::to_double(places[i].x()), CGAL::to_double(places[i].y())};
    fixed_[undirected(corners[i], corners[(i + 1) % 3])] = true;
    for (const double x : rounded_[corners[i]]) size_ = std::max(size_, std::abs(x));
  }
  add_face(corners);
}

int PlaneTriangulation::orient(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return static_cast<int>(CGAL::orientation(place_.at(a), place_.at(b), place_.at(c)));
}

void PlaneTriangulation::set_face(std::size_t i, const Face& f) {
  faces_[i] = f;
  for (std::size_t k = 0; k < 3; ++k) {
    face_at_[directed(f[k], f[(k + 1) % 3])] = i;
    face_of_[f[k]] = i;
    suspects_.push_back(undirected(f[k], f[(k + 1) % 3]));
  }
}

void PlaneTriangulation::add_face(const Face& f) {
  faces_.emplace_back();
  set_face(faces_.size() - 1, f);
}

std::uint32_t PlaneTriangulation::apex(std::uint32_t a, std::uint32_t b) const {
  const auto at = face_at_.find(directed(a, b));
  if (at == face_at_.end()) return kNone;
  for (const std::uint32_t v : faces_[at->second])
    if (v != a && v != b) return v;
  return kNone;
}

void PlaneTriangulation::insert(std::uint32_t vertex, const Point2& place) {
  if (!place_.emplace(vertex, place).second) return;
  rounded_[vertex] = {CGAL::to_double(place.x()), CGAL::to_double(place.y())};
  const std::size_t i = locate(vertex);
  if (i == faces_.size()) return;
  last_ = i;
  const Face f = faces_[i];
  for (std::size_t k = 0; k < 3; ++k) {
    if (orient(f[k], f[(k + 1) % 3], vertex) != 0) continue;
    split_edge(f[k], f[(k + 1) % 3], vertex);
    improve();
    return;
  }
  set_face(i, {f[0], f[1], vertex});
  add_face({f[1], f[2], vertex});
  add_face({f[2], f[0], vertex});
  improve();
}

/// Whether the vertex is right of ab: by rounded places where there can be no doubt.
bool PlaneTriangulation::is_beyond(std::uint32_t a, std::uint32_t b, std::uint32_t vertex) const {
  constexpr double kDoubt = 1e-12;
  const auto &v = rounded_.at(vertex), &p = rounded_.at(a), &q = rounded_.at(b);
  const double det = (q[0] - p[0]) * (v[1] - p[1]) - (q[1] - p[1]) * (v[0] - p[0]);
  return det < -kDoubt * size_ * size_ || orient(a, b, vertex) < 0;
}

bool PlaneTriangulation::holds(const Face& f, std::uint32_t vertex) const {
  return !is_beyond(f[0], f[1], vertex) && !is_beyond(f[1], f[2], vertex) && !is_beyond(f[2], f[0], vertex);
}

/// The face that holds the vertex, the first of two, or the number of faces.
std::size_t PlaneTriangulation::locate(std::uint32_t vertex) const {
  std::size_t at = walk_to(vertex);
  if (at == faces_.size()) {
    for (at = 0; at < faces_.size() && !holds(faces_[at], vertex);) ++at;
    return at;
  }
  const Face& f = faces_[at];
  for (std::size_t k = 0; k < 3; ++k) {
    const auto other = face_at_.find(directed(f[(k + 1) % 3], f[k]));
    if (other != face_at_.end() && orient(f[k], f[(k + 1) % 3], vertex) == 0)
      return std::min(at, other->second);
  }
  return at;
}

/// From face to face towards the vertex. The number of faces if that does not end: where faces are not
/// Delaunay it can go in circles.
std::size_t PlaneTriangulation::walk_to(std::uint32_t vertex) const {
  std::size_t at = last_;
  for (std::size_t step = 0; step < faces_.size(); ++step) {
    const Face& f = faces_[at];
    std::size_t k = 0;
    while (k < 3 && !is_beyond(f[k], f[(k + 1) % 3], vertex)) ++k;
    if (k == 3) return at;
    const auto next = face_at_.find(directed(f[(k + 1) % 3], f[k]));
    if (next == face_at_.end()) break;
    at = next->second;
  }
  return faces_.size();
}

/// Both faces beside it, if it has two; what was fixed stays so.
void PlaneTriangulation::split_edge(std::uint32_t a, std::uint32_t b, std::uint32_t vertex) {
  const std::uint32_t left = apex(a, b), right = apex(b, a);
  const bool was_fixed = fixed_.contains(undirected(a, b));
  const auto split = [&](std::uint32_t from, std::uint32_t to, std::uint32_t third) {
    const std::size_t i = face_at_.at(directed(from, to));
    face_at_.erase(directed(from, to));
    set_face(i, {from, vertex, third});
    add_face({vertex, to, third});
  };
  if (left != kNone) split(a, b, left);
  if (right != kNone) split(b, a, right);
  if (!was_fixed) return;
  fixed_.erase(undirected(a, b));
  fixed_[undirected(a, vertex)] = true;
  fixed_[undirected(vertex, b)] = true;
}

void PlaneTriangulation::flip(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t c = apex(a, b), d = apex(b, a);
  const std::size_t i = face_at_.at(directed(a, b)), j = face_at_.at(directed(b, a));
  face_at_.erase(directed(a, b));
  face_at_.erase(directed(b, a));
  set_face(i, {a, d, c});
  set_face(j, {d, b, c});
}

/// By rounded places: an edge that two angles of more than 180 degrees together are opposite to. Only for
/// shape, so that errors do no harm.
bool PlaneTriangulation::worth_flipping(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t c = apex(a, b), d = apex(b, a);
  if (c == kNone || d == kNone) return false;
  const auto& p = rounded_;
  const auto angle = [&](std::uint32_t v) {
    const double ux = p.at(a)[0] - p.at(v)[0], uy = p.at(a)[1] - p.at(v)[1];
    const double wx = p.at(b)[0] - p.at(v)[0], wy = p.at(b)[1] - p.at(v)[1];
    return std::abs(std::atan2(ux * wy - uy * wx, ux * wx + uy * wy));
  };
  constexpr double kPi = 3.14159265358979323846, kMargin = 1e-6;
  if (!(angle(c) + angle(d) > kPi + kMargin)) return false;
  return orient(c, a, d) > 0 && orient(d, b, c) > 0;
}

void PlaneTriangulation::improve() {
  const std::size_t most = 100 + 20 * faces_.size();  // rounding could lead in circles
  for (std::size_t flips = 0; !suspects_.empty() && flips < most;) {
    const std::uint64_t edge = suspects_.back();
    suspects_.pop_back();
    const auto a = static_cast<std::uint32_t>(edge >> 32), b = static_cast<std::uint32_t>(edge);
    if (fixed_.contains(edge) || !worth_flipping(a, b)) continue;
    flip(a, b);
    ++flips;
  }
  suspects_.clear();
}

/// What a -> b meets of the face, at whose corner a it begins.
std::array<std::uint32_t, 2> PlaneTriangulation::meets_in(std::size_t face, std::uint32_t a,
                                                          std::uint32_t b) const {
  const Face& f = faces_[face];
  const std::size_t k = f[0] == a ? 0 : f[1] == a ? 1 : 2;
  const std::uint32_t v = f[(k + 1) % 3], w = f[(k + 2) % 3];
  const int to_v = orient(a, v, b), to_w = orient(a, w, b);
  const auto ahead = [&](std::uint32_t x) {
    return CGAL::angle(place_.at(x), place_.at(a), place_.at(b)) == CGAL::ACUTE;
  };
  if (to_v == 0 && ahead(v)) return {v, kNone};
  if (to_w == 0 && ahead(w)) return {w, kNone};
  if (to_v > 0 && to_w < 0) return {v, w};
  return {kNone, kNone};
}

/// Around a, to the left until the circle is closed or the border is met, then to the right.
std::array<std::uint32_t, 2> PlaneTriangulation::first_beyond(std::uint32_t a, std::uint32_t b) const {
  const auto start = face_of_.find(a);
  for (const bool left : {true, false}) {
    std::size_t i = start == face_of_.end() ? faces_.size() : start->second;
    while (i < faces_.size()) {
      if (const auto met = meets_in(i, a, b); met[0] != kNone) return met;
      const Face& f = faces_[i];
      const std::size_t k = f[0] == a ? 0 : f[1] == a ? 1 : 2;
      const auto next = face_at_.find(left ? directed(a, f[(k + 2) % 3]) : directed(f[(k + 1) % 3], a));
      if (next == face_at_.end() || next->second == start->second) break;
      i = next->second;
    }
  }
  return {kNone, kNone};
}

void PlaneTriangulation::insert_segment(std::uint32_t a, std::uint32_t b, const NameCrossing& name) {
  while (a != b) {
    const auto [v, w] = first_beyond(a, b);
    if (v == kNone) return;
    if (w == kNone) {
      fixed_[undirected(a, v)] = true;
      a = v;
    } else if (!force(a, b, name)) {
      return;
    }
  }
}

/// Clears the way from a to b up to the first vertex on it: by flips, or with a new vertex on a segment that
/// crosses it. False if that is impossible, which exact arithmetic excludes.
bool PlaneTriangulation::force(std::uint32_t a, std::uint32_t b, const NameCrossing& name) {
  std::deque<std::array<std::uint32_t, 2>> crossed;
  auto edge = first_beyond(a, b);  // its first vertex is to the right
  std::uint32_t end = kNone;
  while (end == kNone) {
    if (fixed_.contains(undirected(edge[0], edge[1]))) {
      Point2 where;
      const std::uint32_t v = name(a, b, edge[0], edge[1], where);
      if (!place_.emplace(v, where).second) return false;
      rounded_[v] = {CGAL::to_double(where.x()), CGAL::to_double(where.y())};
      split_edge(edge[0], edge[1], v);
      if (crossed.empty()) {
        suspects_.clear();
        return true;
      }
      end = v;
      break;
    }
    crossed.push_back(edge);
    const std::uint32_t next = apex(edge[1], edge[0]);
    if (next == kNone) return false;
    const int side = orient(a, b, next);
    if (side == 0)
      end = next;
    else
      edge = side > 0 ? std::array{edge[0], next} : std::array{next, edge[1]};
  }
  const std::size_t most = 1000 + 100 * crossed.size() * crossed.size();
  for (std::size_t step = 0; !crossed.empty(); ++step) {
    if (step > most) return false;
    const auto [right, left] = crossed.front();
    crossed.pop_front();
    const std::uint32_t c = apex(right, left), d = apex(left, right);
    if (orient(c, right, d) <= 0 || orient(d, left, c) <= 0) {
      crossed.push_back({right, left});
      continue;
    }
    flip(right, left);
    const int at_c = c == a || c == end ? 0 : orient(a, end, c),
              at_d = d == a || d == end ? 0 : orient(a, end, d);
    if (at_c * at_d < 0) crossed.push_back(at_c < 0 ? std::array{c, d} : std::array{d, c});
  }
  fixed_[undirected(a, end)] = true;
  improve();
  return true;
}

}  // namespace weft::meshing
