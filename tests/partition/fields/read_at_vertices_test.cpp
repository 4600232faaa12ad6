// Values read at the points of another mesh, where its tets are: those of one process, to the bit.
#include "partition/fields/read_at_vertices.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "meshing/fields/interpolate.h"
#include "partition/communication/morton_shares.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"
#include "tests/support/slivers.h"

namespace weft::partition::read_at_vertices_test {
namespace {

using meshing::MeshData;
using meshing::Point;
using meshing::ValueTable;

/// Two columns that no tet interpolates alike.
ValueTable values_at(const std::vector<std::uint32_t>& numbers) {
  ValueTable table{2, {}};
  for (const std::uint32_t number : numbers)
    table.values.insert(table.values.end(), {1.0 / (1 + number), static_cast<double>(number * 7919 % 101)});
  return table;
}

ValueTable in_one_process(const MeshData& of, const MeshData& at) {
  std::vector<std::uint32_t> numbers(of.points.size());
  for (std::uint32_t v = 0; v < numbers.size(); ++v) numbers[v] = v;
  return interpolate(meshing::locator_in(of), values_at(numbers), at.points).table;
}

MeshData moved(MeshData mesh, double scale, meshing::Vec by) {
  for (Point& p : mesh.points) p = Point{scale * p.x, scale * p.y, scale * p.z} + by;
  return mesh;
}

/// A third of the tets are missing, and of the others a third have vertices of their own: holes, slits,
/// bodies that touch in a vertex, an edge or a face; points without tets.
MeshData torn(MeshData mesh, unsigned seed) {
  std::mt19937 random(seed);
  std::erase_if(mesh.tets, [&](const meshing::Tet&) { return random() % 3 == 0; });
  mesh.tet_refs.resize(mesh.tets.size());
  for (meshing::Tet& tet : mesh.tets) {
    if (random() % 3 != 0) continue;
    for (std::uint32_t& v : tet) {
      mesh.points.push_back(mesh.points[v]);
      v = static_cast<std::uint32_t>(mesh.points.size() - 1);
    }
  }
  mesh.point_refs.resize(mesh.points.size());
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  return mesh;
}

class ReadAtVertices : public testing::TestWithParam<int> {};

void expect_bits_of_one_process(const MeshData& of, const MeshData& at, int ranks) {
  const ValueTable expected = in_one_process(of, at);
  support::run_ranks(ranks, [&](Peers& peers) {
    const auto slice_of_whole = support::slice_of({of, {}}, peers.rank(), ranks, 1);
    const auto slice_of_points = support::slice_of({at, {}}, peers.rank(), ranks, 2);
    const MortonShares shares = morton_shares(peers, {slice_of_whole.points, slice_of_points.points});
    const PartDomain from(peers, slice_of_whole, 1, shares), to(peers, slice_of_points, 1, shares);
    const ValueTable read =
        read_at_vertices(peers, from, values_at(from.numbers()), to, norm(shares.box.size()));
    ASSERT_EQ(read.values.size(), 2 * to.numbers().size());
    for (std::size_t v = 0; v < to.numbers().size(); ++v)
      for (std::size_t c = 0; c < 2; ++c)
        EXPECT_EQ(read.values[2 * v + c], expected.values[2 * to.numbers()[v] + c]) << to.numbers()[v];
  });
}

TEST_P(ReadAtVertices, HasTheBitsOfOneProcess) {
  // Points that are on vertices, edges and faces; outside, near and far; between bodies that are not joined.
  const std::pair<MeshData, MeshData> pairs[] = {
      {support::unit_cube(6), support::unit_cube(4)},
      {support::with_slivers(support::turned(support::unit_cube(5)), 1),
       support::turned(support::unit_cube(7))},
      {support::ball(2, 3), support::ball(3, 4)},
      {support::touching_cells(4, 3), support::unit_cube(5)},
      {support::unit_cube(5), moved(support::unit_cube(4), 3, {-1, -0.5, 0})},
      {support::unit_cube(5), moved(support::unit_cube(3), 1, {40, 0, 0})}};
  for (const auto& [of, at] : pairs) expect_bits_of_one_process(of, at, GetParam());
}

TEST_P(ReadAtVertices, HasTheBitsOfOneProcessInTornMeshes) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    expect_bits_of_one_process(torn(support::unit_cube(3), seed), support::unit_cube(6), GetParam());
    expect_bits_of_one_process(torn(support::turned(support::unit_cube(4)), seed),
                               torn(support::turned(support::unit_cube(5)), seed + 1), GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(Ranks, ReadAtVertices, testing::ValuesIn(support::kNumbersOfRanks));

}  // namespace
}  // namespace weft::partition::read_at_vertices_test
