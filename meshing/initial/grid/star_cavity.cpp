#include "meshing/initial/grid/star_cavity.h"

#include <algorithm>

namespace weft::meshing {
namespace {

template <class Simplex>
bool holds(const Simplex& s, std::uint32_t v) {
  return std::find(s.begin(), s.end(), v) != s.end();
}

}  // namespace

void StarCavity::begin(std::uint32_t vertex, std::span<const std::uint32_t> tets, std::span<const Face3> lids,
                       std::span<const std::uint32_t> blocked) {
  vertex_ = vertex;
  seed_ = tets;
  lids_ = lids;
  blocked_ = blocked;
}

bool StarCavity::improve(Star& star, std::uint32_t v) {
  if (!take(v, star.worst)) return false;
  star.old = cavity_;
  star.fresh.clear();
  star.worst = 1;
  for (const Wall& w : walls_) {
    if (w.beyond != kNothing && inside(w.beyond >> 2)) continue;
    star.fresh.push_back(w.tet);
    star.worst = std::min(star.worst, w.shape);
  }
  return true;
}

bool StarCavity::take(std::uint32_t v, double limit) {
  walls_.clear();
  cavity_.clear();
  ++stamp_;
  for (const auto& [a, b, c] : lids_) {
    if (a == v || b == v || c == v) continue;
    walls_.push_back({{a, b, c, v}, kNothing, grid_.shape_above({a, b, c, v}, limit)});
    if (walls_.back().shape <= limit) return false;
  }
  for (const std::uint32_t t : seed_) include(t);
  for (std::size_t i = 0; i < cavity_.size(); ++i)
    if (!take_tet(cavity_[i], v, limit)) return false;
  return true;
}

/// Makes walls of the tet's outer faces, or passes them.
bool StarCavity::take_tet(std::uint32_t t, std::uint32_t v, double limit) {
  const TetGrid::Tet& tet = grid_.tets[t];
  for (int f = 0; f < 4; ++f) {
    const Face3 w = grid_.face(t, f);
    if (tet.n[f] != kNothing && inside(tet.n[f] >> 2)) {
      if (tet.facet[f] != kNothing) return false;
      continue;
    }
    if (holds(w, v) || (tet.facet[f] != kNothing && holds(w, vertex_))) continue;
    const Tet4 fresh = {w[0], w[1], w[2], v};
    const double shape = grid_.shape_above(fresh, limit);
    if (shape > limit)
      walls_.push_back({fresh, tet.n[f], shape});
    else if (!pass(t, f))
      return false;
  }
  return true;
}

bool StarCavity::pass(std::uint32_t t, int face) {
  const std::uint32_t next = grid_.tets[t].n[face];
  if (next == kNothing || grid_.tets[t].facet[face] != kNothing || cavity_.size() >= kMostTets) return false;
  if (holds(blocked_, next >> 2)) return false;
  include(next >> 2);
  return true;
}

void StarCavity::include(std::uint32_t t) {
  if (stamps_.size() < grid_.tets.size()) stamps_.resize(grid_.tets.size(), 0);
  stamps_[t] = stamp_;
  cavity_.push_back(t);
}

std::span<const std::uint32_t> fill(TetGrid& grid, const Star& star, std::span<const FacetFace> facets) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t t : star.old)
    vertices.insert(vertices.end(), grid.tets[t].v.begin(), grid.tets[t].v.end());
  for (const std::uint32_t v : vertices) grid.vertex_tet[v] = kNothing;
  return grid.replace(star.old, star.fresh, facets);
}

}  // namespace weft::meshing
