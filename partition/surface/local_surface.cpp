// Vertices are asked for at their homes, ring by ring.
#include "partition/surface/local_surface.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "meshing/base/place_in.h"
#include "meshing/base/release.h"
#include "meshing/base/sort_unique.h"
#include "partition/communication/at_home.h"

namespace weft::partition {
namespace {

template <class Triangles, class Vertices>
std::vector<std::uint32_t> vertices_among(const Triangles& triangles, const Vertices& vertices) {
  std::vector<std::uint32_t> all;
  for (const auto& t : triangles)
    for (const std::uint32_t v : vertices(t)) all.push_back(v);
  meshing::sort_unique(all);
  return all;
}

}  // namespace

SurfaceNeighbours::SurfaceNeighbours(Peers& peers, const BoundaryShare& share, const FetchPoints& points)
    : peers_(peers), share_(share), points_(points) {
  if (peers.ranks() > 1) send_home();
}

/// A triangle goes to each home of a vertex once.
void SurfaceNeighbours::send_home() {
  const auto ranks = static_cast<std::uint32_t>(peers_.ranks()),
             me = static_cast<std::uint32_t>(peers_.rank());
  std::vector<std::vector<Owned>> to_each(ranks);
  for (const BoundaryTriangle& t : share_.triangles) {
    const std::array<std::uint32_t, 3> homes{t.vertices[0] % ranks, t.vertices[1] % ranks,
                                             t.vertices[2] % ranks};
    for (std::size_t i = 0; i < 3; ++i)
      if (std::find(homes.begin(), homes.begin() + static_cast<std::ptrdiff_t>(i), homes[i]) ==
          homes.begin() + static_cast<std::ptrdiff_t>(i))
        to_each[homes[i]].push_back({t, me});
  }
  here_ = all_to_all_joined(peers_, std::move(to_each));
  for (std::uint32_t i = 0; i < here_.size(); ++i)
    for (const std::uint32_t v : here_[i].triangle.vertices)
      if (v % ranks == me) at_vertex_.emplace_back(v, i);
  std::ranges::sort(at_vertex_);
}

/// All triangles at these vertices, by number.
std::vector<SurfaceNeighbours::Owned> SurfaceNeighbours::at(
    const std::vector<std::uint32_t>& vertices) const {
  auto asked = asked_at_home(peers_, vertices);
  std::vector<std::vector<Owned>> answers(asked.size());
  for (std::size_t r = 0; r < asked.size(); ++r) {
    std::vector<std::uint32_t> places;
    for (const std::uint32_t v : asked[r])
      for (auto i = std::ranges::lower_bound(at_vertex_, std::pair{v, 0u});
           i != at_vertex_.end() && i->first == v; ++i)
        places.push_back(i->second);
    meshing::sort_unique(places);
    for (const std::uint32_t i : places) answers[r].push_back(here_[i]);
  }
  asked = {};
  std::vector<Owned> found = all_to_all_joined(peers_, std::move(answers));
  meshing::sort_unique(found, [](const Owned& t) { return t.triangle.number; });
  return found;
}

/// Edges between the vertices, and which of these are listed.
void SurfaceNeighbours::add_listed(LocalSurface& local) const {
  local.asked = asked_at_home(peers_, local.vertices);
  if (share_.any_listed_points)
    take_listed_points(peers_, local.asked, share_.listed_points, local.vertices, local.mesh);
  std::vector<BoundaryEdge> here = share_.edges;
  std::ranges::sort(here, {}, &BoundaryEdge::vertices);
  meshing::MeshData& mesh = local.mesh;
  for (const BoundaryEdge& e : told_between(peers_, local.asked, local.vertices, std::move(here))) {
    if (e.required) mesh.required_edges.push_back(static_cast<std::uint32_t>(mesh.edges.size()));
    mesh.edges.push_back({static_cast<std::uint32_t>(meshing::place_in(local.vertices, e.vertices[0])),
                          static_cast<std::uint32_t>(meshing::place_in(local.vertices, e.vertices[1]))});
    mesh.edge_refs.push_back(e.ref);
  }
}

LocalSurface SurfaceNeighbours::around(std::vector<BoundaryTriangle> own) const {
  const auto of_own = [](const BoundaryTriangle& t) -> const auto& { return t.vertices; };
  const auto of_owned = [](const Owned& t) -> const auto& { return t.triangle.vertices; };
  std::ranges::sort(own, {}, &BoundaryTriangle::number);
  LocalSurface local;
  std::vector<Owned> all;
  std::vector<std::uint32_t> touched = vertices_among(own, of_own);
  if (peers_.ranks() == 1) {
    for (const BoundaryTriangle& t : own) all.push_back({t, 0});
    local.vertices = std::move(touched);
  } else {
    const std::vector<Owned> first = at(touched);
    touched = vertices_among(first, of_owned);
    all = at(touched);  // the first ring and what it has around it
    for (const Owned& t : all) {
      const auto is_in = [&](const auto& list, const auto& number) {
        return std::ranges::binary_search(list, t.triangle.number, {}, number);
      };
      const bool near = is_in(first, [](const Owned& o) { return o.triangle.number; });
      local.rings.push_back(is_in(own, &BoundaryTriangle::number) ? 0 : near ? 1 : 2);
    }
    local.vertices = vertices_among(all, of_owned);
  }
  meshing::release(own);
  for (const auto& [t, owner] : all) {
    const auto place = [&](std::uint32_t v) {
      return static_cast<std::uint32_t>(meshing::place_in(local.vertices, v));
    };
    if (t.required)
      local.mesh.required_triangles.push_back(static_cast<std::uint32_t>(local.triangles.size()));
    local.triangles.push_back(t.number);
    local.owners.push_back(owner);
    local.mesh.triangles.push_back({place(t.vertices[0]), place(t.vertices[1]), place(t.vertices[2])});
    local.mesh.triangle_refs.push_back(t.ref);
  }
  meshing::release(all);
  add_listed(local);
  local.mesh.points = points_(local.vertices);
  return local;
}

}  // namespace weft::partition
