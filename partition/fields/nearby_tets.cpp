// Cells are asked for at their homes, and tets sent to who has boxes that they meet.
#include "partition/fields/nearby_tets.h"

#include <algorithm>
#include <array>
#include <ranges>
#include <utility>

#include "meshing/base/freed_memory.h"
#include "meshing/base/place_index.h"
#include "meshing/base/release.h"
#include "meshing/base/sort_unique.h"
#include "partition/fields/box_tree.h"
#include "partition/fields/cell_homes.h"
#include "partition/fields/surroundings.h"

namespace weft::partition {
namespace {

using meshing::Box;
using meshing::MeshData;
using meshing::Tet;

/// What is around a part.
std::vector<Box> boxes_around(const MeshData& mesh, std::span<const double> reach) {
  constexpr std::size_t kMost = 32768;  // each takes 48 bytes, and 96 in a tree
  std::vector<Box> boxes = boxes_of_tets(mesh, kMost, reach);
  std::vector<bool> has_tet(mesh.points.size(), false);
  for (const Tet& tet : mesh.tets)
    for (const std::uint32_t v : tet) has_tet[v] = true;
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
    if (!has_tet[v]) boxes.push_back(Box{mesh.points[v], mesh.points[v]}.grown(reach[v]));
  return boxes;
}

/// Each tet of the mesh in parts is one rank's: that which owns its first vertex.
bool has(const PartDomain& of, const Tet& tet) { return of.owns(std::ranges::min(tet)); }

}  // namespace

NearbyTets::NearbyTets(Peers& peers, const PartDomain& of, const PartDomain& around,
                       std::span<const double> reach)
    : peers_(peers) {
  const CellGrid grid = common_grid(peers, of, around);
  const MeshData& mesh = of.mesh();
  std::vector<std::uint32_t> own;
  Box of_own;
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    if (!has(of, mesh.tets[t])) continue;
    own.push_back(t);
    of_own.unite(box_of(mesh, mesh.tets[t]));
  }
  const auto boxes = own | std::views::transform([&](std::uint32_t t) { return box_of(mesh, mesh.tets[t]); });
  std::vector<Box> mine = boxes_around(around.mesh(), reach);
  std::vector<int> asked;
  for (const auto& ranks : ranks_wanting(peers, grid, grid.cells_of(boxes), grid.cells_of(mine)))
    asked.insert(asked.end(), ranks.begin(), ranks.end());
  meshing::sort_unique(asked);
  std::vector<std::vector<Box>> around_each = ask_for_boxes(peers, asked, of_own, mine);
  meshing::release(mine);
  std::vector<std::vector<std::uint32_t>> tets_for(around_each.size());
  for (std::size_t r = 0; r < around_each.size(); ++r) {
    if (around_each[r].empty()) continue;
    BoxTree tree(around_each[r]);
    meshing::release(around_each[r]);
    for (const std::uint32_t t : own)
      if (tree.meets(box_of(mesh, mesh.tets[t]))) tets_for[r].push_back(t);
  }
  meshing::release(own);
  send(of, std::move(tets_for));
  meshing::give_back_freed_memory();  // what it took to find and sort them is more than they are
}

void NearbyTets::send(const PartDomain& of, std::vector<std::vector<std::uint32_t>>&& tets_for) {
  std::vector<std::vector<VertexRecord>> vertices(tets_for.size());
  std::vector<std::vector<Tet>> tets(tets_for.size());
  given_.resize(tets_for.size());
  for (std::size_t r = 0; r < tets_for.size(); ++r) {
    if (tets_for[r].empty()) continue;
    std::vector<bool> is_given(of.mesh().points.size(), false);
    tets[r].reserve(tets_for[r].size());
    for (const std::uint32_t t : std::exchange(tets_for[r], {})) {
      Tet& tet = tets[r].emplace_back(of.mesh().tets[t]);
      for (std::uint32_t& v : tet) {
        is_given[v] = true;
        v = of.numbers()[v];
      }
    }
    for (std::uint32_t v = 0; v < is_given.size(); ++v)
      if (is_given[v]) given_[r].push_back(v);
    for (const std::uint32_t v : given_[r]) vertices[r].push_back({of.numbers()[v], of.mesh().points[v]});
  }
  std::vector<Tet> all = all_to_all_joined(peers_, std::move(tets));
  build(partition::all_to_all(peers_, std::move(vertices)), std::move(all));
}

/// In an order that does not depend on who has sent what.
void NearbyTets::build(const std::vector<std::vector<VertexRecord>>& vertices, std::vector<Tet>&& tets) {
  std::vector<VertexRecord> all;
  for (const auto& of_rank : vertices) all.insert(all.end(), of_rank.begin(), of_rank.end());
  std::ranges::sort(all, {}, &VertexRecord::number);
  const auto rest = std::ranges::unique(all, {}, &VertexRecord::number);
  all.erase(rest.begin(), rest.end());
  std::vector<std::uint32_t> numbers;
  numbers.reserve(all.size());
  for (const VertexRecord& vertex : all) numbers.push_back(static_cast<std::uint32_t>(vertex.number));
  const meshing::PlaceIndex local(numbers);
  taken_.resize(vertices.size());
  for (std::size_t r = 0; r < vertices.size(); ++r)
    for (const VertexRecord& vertex : vertices[r])
      taken_[r].push_back(local(static_cast<std::uint32_t>(vertex.number)));
  std::ranges::sort(tets);
  for (Tet& tet : tets)
    for (std::uint32_t& v : tet) v = local(v);
  mesh_.tets = std::move(tets);
  mesh_.tet_refs.resize(mesh_.tets.size());
  for (const VertexRecord& vertex : all) {
    mesh_.points.push_back(vertex.point);
    numbers_.push_back(vertex.number);
  }
  mesh_.point_refs.resize(mesh_.points.size());
}

meshing::ValueTable NearbyTets::carry(const meshing::ValueTable& at_part) const {
  const std::size_t n = at_part.columns;
  std::vector<std::vector<double>> to_each(given_.size());
  for (std::size_t r = 0; r < given_.size(); ++r) {
    to_each[r].reserve(given_[r].size() * n);
    for (const std::uint32_t v : given_[r])
      to_each[r].insert(to_each[r].end(), at_part.values.begin() + static_cast<std::ptrdiff_t>(v * n),
                        at_part.values.begin() + static_cast<std::ptrdiff_t>((v + 1) * n));
  }
  meshing::ValueTable table{n, std::vector<double>(mesh_.points.size() * n)};
  const std::vector<std::vector<double>> from_each = partition::all_to_all(peers_, std::move(to_each));
  for (std::size_t r = 0; r < taken_.size(); ++r)
    for (std::size_t i = 0; i < taken_[r].size(); ++i)
      std::copy_n(from_each[r].data() + i * n, n, table.values.data() + taken_[r][i] * n);
  return table;
}

}  // namespace weft::partition
