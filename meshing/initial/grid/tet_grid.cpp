// Exchange of tets: old outer faces and new faces are sorted together, equal ones are glued.
#include "meshing/initial/grid/tet_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "meshing/initial/grid/interrupted.h"
#include "meshing/mesh/predicates.h"

namespace weft::meshing {

Face3 face_key(const Face3& f) {
  Face3 k = f;
  std::sort(k.begin(), k.end());
  return k;
}

std::uint32_t TetGrid::add_point(const Point& p) {
  points.push_back(p);
  vertex_tet.push_back(kNothing);
  return static_cast<std::uint32_t>(points.size() - 1);
}

void TetGrid::place_exactly(std::uint32_t v, const ExactPlace& place) {
  if (exact_.size() <= v) exact_.resize(v + 1, kNothing);
  exact_[v] = static_cast<std::uint32_t>(places_.size());
  places_.push_back(place);
  points[v] = place.rounded();
}

void TetGrid::move(std::uint32_t v, const Point& p) {
  if (is_exact(v)) exact_[v] = kNothing;
  points[v] = p;
}

ExactPlace TetGrid::place(std::uint32_t v) const {
  return is_exact(v) ? places_[exact_[v]] : ExactPlace::at(points[v]);
}

namespace {

double largest_coordinate(const Point& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

/// The sign of orientation() where it is the same for all points that are rounded to these, else 0: each
/// coordinate is off by a unit in its last place at most (2.3e-16 of the largest), a difference by twice
/// that, and each of the three differences has minors of at most twice the largest one's square.
int sign_of_rounded(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Vec u = b - a, v = c - a, w = d - a;
  const double longest = std::max({largest_coordinate(u), largest_coordinate(v), largest_coordinate(w)});
  const double farthest =
      std::max({largest_coordinate(a), largest_coordinate(b), largest_coordinate(c), largest_coordinate(d)});
  const double det = dot(cross(u, v), w);
  // Twice what it can be; the least normal number where products are smaller than that.
  const double bound = 2e-14 * (farthest + longest) * longest * longest + std::numeric_limits<double>::min();
  return det > bound ? 1 : det < -bound ? -1 : 0;
}

}  // namespace

int TetGrid::orient(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
  if (is_exact(a) || is_exact(b) || is_exact(c) || is_exact(d)) {
    const int sign = sign_of_rounded(points[a], points[b], points[c], points[d]);
    return sign != 0 ? sign : orientation(place(a), place(b), place(c), place(d));
  }
  return orientation(points[a], points[b], points[c], points[d]);
}

int TetGrid::orient(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Point& d) const {
  if (is_exact(a) || is_exact(b) || is_exact(c))
    return orientation(place(a), place(b), place(c), ExactPlace::at(d));
  return orientation(points[a], points[b], points[c], d);
}

double TetGrid::shape(const Tet4& v) const { return shape_above(v, 0); }

double TetGrid::shape_above(const Tet4& v, double enough) const {
  double edges = 0;
  for (const auto& e : kTetEdges) edges += norm2(points[v[e[0]]] - points[v[e[1]]]);
  const double volume = six_volume(points[v[0]], points[v[1]], points[v[2]], points[v[3]]);
  const double shape = std::max(volume / (edges * std::sqrt(edges)), 1e-300);
  if (enough > 0 && shape <= enough) return 0;
  return positive(v) ? shape : 0;
}

bool TetGrid::sliver(const Tet4& v) const {
  double shortest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const auto& e : kTetEdges) shortest = std::min(shortest, norm2(points[v[e[0]]] - points[v[e[1]]]));
  for (const auto& f : kTetFaces) {
    const Point& a = points[v[f[0]]];
    largest = std::max(largest, norm2(cross(points[v[f[1]]] - a, points[v[f[2]]] - a)));
  }
  const double volume = six_volume(points[v[0]], points[v[1]], points[v[2]], points[v[3]]);
  return volume < 1e-9 * std::sqrt(largest * shortest);
}

int TetGrid::local_index(std::uint32_t t, std::uint32_t v) const {
  const Tet4& w = tets[t].v;
  for (int i = 0; i < 4; ++i)
    if (w[i] == v) return i;
  return -1;
}

std::uint32_t TetGrid::take_slot() {
  if (free_.empty()) {
    tets.emplace_back();
    return static_cast<std::uint32_t>(tets.size() - 1);
  }
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  tets[slot] = {};
  return slot;
}

void TetGrid::collect_outer(std::span<const std::uint32_t> old) {
  begin_marking();
  for (const std::uint32_t t : old) mark(t);
  for (const std::uint32_t t : old)
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t n = tets[t].n[f];
      if (n != kNothing && marked(n >> 2)) continue;
      sides_.push_back({face_key(face(t, f)), n, tets[t].facet[f], true});
    }
}

void TetGrid::collect_fresh(std::span<const std::uint32_t> slots) {
  for (const std::uint32_t t : slots)
    for (int f = 0; f < 4; ++f)
      sides_.push_back({face_key(face(t, f)), 4 * t + static_cast<std::uint32_t>(f), kNothing, false});
}

void TetGrid::glue_sides() {
  std::sort(sides_.begin(), sides_.end(),
            [](const Side& a, const Side& b) { return a.key != b.key ? a.key < b.key : a.outer > b.outer; });
  const auto set = [&](std::uint32_t at, std::uint32_t n) {
    if (at != kNothing) tets[at >> 2].n[at & 3] = n;
  };
  for (std::size_t i = 0; i + 1 < sides_.size(); ++i) {
    const Side &a = sides_[i], &b = sides_[i + 1];
    if (a.key != b.key) continue;
    set(a.code, b.code);
    set(b.code, a.code);
    if (a.outer) tets[b.code >> 2].facet[b.code & 3] = a.facet;
    ++i;
  }
}

std::span<const std::uint32_t> TetGrid::replace(std::span<const std::uint32_t> old,
                                                std::span<const Tet4> fresh,
                                                std::span<const FacetFace> facets) {
  check_interrupt(interrupt);
  sides_.clear();
  collect_outer(old);
  for (const std::uint32_t t : old) remove(t);
  slots_.clear();
  for (const Tet4& v : fresh) {
    const std::uint32_t t = take_slot();
    tets[t].v = v;
    slots_.push_back(t);
    for (const std::uint32_t w : v) vertex_tet[w] = t;
  }
  collect_fresh(slots_);
  glue_sides();
  for (const FacetFace& f : facets)
    for (const std::uint32_t t : slots_)
      for (int i = 0; i < 4; ++i)
        if (face_key(face(t, i)) == face_key(f.vertices)) tets[t].facet[i] = f.facet;
  return slots_;
}

bool TetGrid::star(std::span<const std::uint32_t> cavity, std::uint32_t v, std::vector<Tet4>& fresh) {
  fresh.clear();
  beyond_.clear();
  begin_marking();
  for (const std::uint32_t t : cavity) mark(t);
  for (const std::uint32_t t : cavity)
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t n = tets[t].n[f];
      if (n != kNothing && marked(n >> 2)) continue;
      const Face3 w = face(t, f);
      fresh.push_back({w[0], w[1], w[2], v});
      beyond_.push_back({n, tets[t].facet[f]});
      if (!positive(fresh.back())) return false;
    }
  return true;
}

std::span<const std::uint32_t> TetGrid::fill_star(std::span<const std::uint32_t> cavity,
                                                  std::span<const Tet4> fresh) {
  check_interrupt(interrupt);
  for (const std::uint32_t t : cavity) remove(t);
  if (spokes_.size() < 4 * fresh.size()) spokes_.assign(std::bit_ceil(8 * fresh.size()), {});
  ++spoke_stamp_;
  slots_.clear();
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    const std::uint32_t t = take_slot();
    const Tet4& v = tets[t].v = fresh[i];
    slots_.push_back(t);
    for (const std::uint32_t w : v) vertex_tet[w] = t;
    tets[t].n[3] = beyond_[i].code;
    tets[t].facet[3] = beyond_[i].facet;
    if (beyond_[i].code != kNothing) tets[beyond_[i].code >> 2].n[beyond_[i].code & 3] = 4 * t + 3;
    for (std::uint32_t f = 0; f < 3; ++f) glue_spoke(v[(f + 1) % 3], v[(f + 2) % 3], 4 * t + f);
  }
  return slots_;
}

void TetGrid::glue_spoke(std::uint32_t u, std::uint32_t w, std::uint32_t code) {
  const std::uint64_t edge = u < w ? std::uint64_t{u} << 32 | w : std::uint64_t{w} << 32 | u;
  const std::size_t mask = spokes_.size() - 1;
  for (std::size_t at = (edge * 0x9E3779B97F4A7C15ull) >> 32;; ++at) {
    Spoke& spoke = spokes_[at & mask];
    if (spoke.stamp == spoke_stamp_ && spoke.edge != edge) continue;
    if (spoke.stamp != spoke_stamp_) {
      spoke = {edge, code, spoke_stamp_};
      return;
    }
    tets[code >> 2].n[code & 3] = spoke.code;
    tets[spoke.code >> 2].n[spoke.code & 3] = code;
    return;
  }
}

void TetGrid::remove(std::uint32_t t) {
  tets[t].v = {0, 0, 0, 0};
  free_.push_back(t);
}

void TetGrid::set_facet(std::uint32_t t, int f, std::uint32_t facet) {
  tets[t].facet[f] = facet;
  const std::uint32_t n = tets[t].n[f];
  if (n != kNothing) tets[n >> 2].facet[n & 3] = facet;
}

void TetGrid::ball(std::uint32_t v, std::vector<std::uint32_t>& out) {
  out.clear();
  begin_marking();
  mark(vertex_tet[v]);
  out.push_back(vertex_tet[v]);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint32_t t = out[i];
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t n = tets[t].n[f];
      if (tets[t].v[f] != v && n != kNothing && mark(n >> 2)) out.push_back(n >> 2);
    }
  }
}

std::uint32_t TetGrid::tet_with_edge(std::uint32_t a, std::uint32_t b) {
  ball(a, around_);
  for (const std::uint32_t t : around_)
    if (local_index(t, b) >= 0) return t;
  return kNothing;
}

void TetGrid::shell(std::uint32_t tet, std::uint32_t a, std::uint32_t b, EdgeShell& out) const {
  // Turned so that (a, b, c, d) is an even permutation of the tet: d follows c in positive order.
  const auto others = [&](std::uint32_t t) {
    const int e = kEdgeOf[local_index(t, a)][local_index(t, b)];
    std::uint32_t c = tets[t].v[kTetEdges[e][2]], d = tets[t].v[kTetEdges[e][3]];
    if (tets[t].v[kTetEdges[e][0]] != a) std::swap(c, d);
    return std::pair{c, d};
  };
  const auto across = [&](std::uint32_t t, std::uint32_t v) { return tets[t].n[local_index(t, v)]; };
  out.tets.clear();
  out.ring.clear();
  std::uint32_t first = tet;
  for (std::uint32_t back = across(first, others(first).second); back != kNothing && back >> 2 != tet;) {
    first = back >> 2;
    back = across(first, others(first).second);
  }
  if (across(first, others(first).second) != kNothing) first = tet;
  out.closed = false;
  for (std::uint32_t t = first;;) {
    const auto [c, d] = others(t);
    out.tets.push_back(t);
    out.ring.push_back(c);
    const std::uint32_t next = across(t, c);
    if (next == kNothing) {
      out.ring.push_back(d);
      return;
    }
    t = next >> 2;
    if (t == first) break;
  }
  out.closed = true;
}

std::vector<std::uint32_t> flood_regions(const TetGrid& grid, std::uint32_t& count) {
  std::vector<std::uint32_t> region(grid.tets.size(), kNothing), stack;
  count = 0;
  for (std::uint32_t first = 0; first < grid.tets.size(); ++first) {
    if (!grid.alive(first) || region[first] != kNothing) continue;
    region[first] = count;
    stack.assign(1, first);
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (int f = 0; f < 4; ++f) {
        const std::uint32_t n = grid.tets[t].n[f];
        if (n == kNothing || grid.tets[t].facet[f] != kNothing || region[n >> 2] != kNothing) continue;
        region[n >> 2] = count;
        stack.push_back(n >> 2);
      }
    }
    ++count;
  }
  return region;
}

}  // namespace weft::meshing
