// Cells are asked for at their homes, and tets sent to who has asked.
#include "partition/fields/nearby_tets.h"

#include <algorithm>
#include <array>
#include <utility>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "partition/communication/morton_shares.h"
#include "partition/fields/cell_homes.h"

namespace weft::partition {
namespace {

using meshing::Box;
using meshing::MeshData;
using meshing::Tet;

Box box_of(const MeshData& mesh, const Tet& tet) {
  Box box;
  for (const std::uint32_t v : tet) box.include(mesh.points[v]);
  return box;
}

/// A few points of the coarser mesh a cell.
CellGrid common_grid(Peers& peers, const PartDomain& a, const PartDomain& b) {
  constexpr double kPointsPerCell = 4;
  const auto points = static_cast<double>(std::min(a.num_points(), b.num_points()));
  Box mine;
  for (const MeshData* mesh : {&a.mesh(), &b.mesh()})
    for (const meshing::Point& p : mesh->points) mine.include(p);
  return {common_box(peers, mine), points / kPointsPerCell};
}

/// The cells of the tets and points of a part and those beside them, ascending.
std::vector<std::uint32_t> cells_around(const CellGrid& grid, const MeshData& mesh, std::uint32_t margin) {
  std::vector<std::uint8_t> touched(grid.size(), 0);
  const auto touch = [&](std::uint32_t cell) { touched[cell] = 1; };
  for (const meshing::Point& p : mesh.points) grid.for_each_cell(Box{p, p}, margin, touch);
  for (const Tet& tet : mesh.tets) grid.for_each_cell(box_of(mesh, tet), margin, touch);
  std::vector<std::uint32_t> cells;
  for (std::uint32_t cell = 0; cell < touched.size(); ++cell)
    if (touched[cell]) cells.push_back(cell);
  return cells;
}

/// Each tet of the mesh in parts is one rank's: that which owns its first vertex.
bool has(const PartDomain& of, const Tet& tet) { return of.owns(std::ranges::min(tet)); }

std::vector<std::uint32_t> cells_of_own_tets(const CellGrid& grid, const PartDomain& of) {
  std::vector<bool> touched(grid.size(), false);
  for (const Tet& tet : of.mesh().tets)
    if (has(of, tet)) grid.for_each_cell(box_of(of.mesh(), tet), [&](std::uint32_t c) { touched[c] = true; });
  std::vector<std::uint32_t> cells;
  for (std::uint32_t cell = 0; cell < touched.size(); ++cell)
    if (touched[cell]) cells.push_back(cell);
  return cells;
}

}  // namespace

NearbyTets::NearbyTets(Peers& peers, const PartDomain& of, const PartDomain& around, std::uint32_t margin)
    : peers_(peers) {
  const CellGrid grid = common_grid(peers, of, around);
  reach_ = margin * grid.least_side();
  const MeshData& mesh = of.mesh();
  const std::vector<std::uint32_t> cells = cells_of_own_tets(grid, of);
  const std::vector<std::vector<int>> ranks =
      ranks_wanting(peers, grid, cells, cells_around(grid, around.mesh(), margin));
  std::vector<std::vector<std::uint32_t>> tets_for(static_cast<std::size_t>(peers.ranks()));
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    if (!has(of, mesh.tets[t])) continue;
    grid.for_each_cell(box_of(mesh, mesh.tets[t]), [&](std::uint32_t cell) {
      for (const int rank : ranks[meshing::place_in(cells, cell)]) {
        std::vector<std::uint32_t>& list = tets_for[static_cast<std::size_t>(rank)];
        if (list.empty() || list.back() != t) list.push_back(t);
      }
    });
  }
  send(of, tets_for);
}

void NearbyTets::send(const PartDomain& of, const std::vector<std::vector<std::uint32_t>>& tets_for) {
  std::vector<std::vector<VertexRecord>> vertices(tets_for.size());
  std::vector<std::vector<Tet>> tets(tets_for.size());
  given_.resize(tets_for.size());
  for (std::size_t r = 0; r < tets_for.size(); ++r) {
    for (const std::uint32_t t : tets_for[r]) {
      Tet tet = of.mesh().tets[t];
      given_[r].insert(given_[r].end(), tet.begin(), tet.end());
      for (std::uint32_t& v : tet) v = of.numbers()[v];
      tets[r].push_back(tet);
    }
    meshing::sort_unique(given_[r]);
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
  const auto local = [&](std::uint64_t number) {
    return static_cast<std::uint32_t>(meshing::place_in(all, number, &VertexRecord::number));
  };
  taken_.resize(vertices.size());
  for (std::size_t r = 0; r < vertices.size(); ++r)
    for (const VertexRecord& vertex : vertices[r]) taken_[r].push_back(local(vertex.number));
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
