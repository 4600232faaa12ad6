// Sizes that spread through a volume: along a row of cells, not across a gap.
#include "meshing/initial/spread_sizes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meshing/mesh/structured_box.h"

namespace weft::meshing::spread_sizes_test {
namespace {

/// The vertex at a point.
std::uint32_t vertex_at(const MeshData& mesh, const Point& p) {
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
    if (norm(mesh.points[v] - p) < 1e-12) return v;
  ADD_FAILURE() << "no such vertex";
  return 0;
}

TEST(SpreadSizes, GrowWithTheDistanceFromTheSource) {
  const MeshData row = structured_box({{10, 1, 1}, {0, 0, 0}, {10, 1, 1}});
  const std::vector<SizeSource> source = {{vertex_at(row, {0, 0, 0}), 0.5, 0.3}};
  const std::vector<SpreadSize> sizes = spread_sizes(row, source);
  EXPECT_EQ(sizes[source[0].vertex].size, 0.5);
  EXPECT_NEAR(sizes[vertex_at(row, {7, 0, 0})].size, 0.5 + 0.3 * 7, 1e-12);
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    const double straight = norm(row.points[v] - row.points[source[0].vertex]);
    EXPECT_GE(sizes[v].size, 0.5 + 0.3 * straight - 1e-12);
    EXPECT_LE(sizes[v].size, 0.5 + 0.3 * (straight + 2));
  }
}

TEST(SpreadSizes, TheLeastOfAllSourcesCountsAndSourcesKeepTheirOwn) {
  const MeshData row = structured_box({{10, 1, 1}, {0, 0, 0}, {10, 1, 1}});
  const std::uint32_t small = vertex_at(row, {0, 0, 0}), large = vertex_at(row, {10, 0, 0});
  const std::vector<SpreadSize> sizes =
      spread_sizes(row, std::vector<SizeSource>{{small, 0.1, 0.1}, {large, 5, 1}});
  EXPECT_EQ(sizes[small].size, 0.1);
  EXPECT_EQ(sizes[large].size, 5);
  EXPECT_NEAR(sizes[vertex_at(row, {9, 0, 0})].size, 1.0, 1e-12);
}

TEST(SpreadSizes, DoNotCrossAGap) {
  MeshData two = structured_box({{2, 2, 2}, {0, 0, 0}, {1, 1, 1}});
  const MeshData other = structured_box({{2, 2, 2}, {1.001, 0, 0}, {2.001, 1, 1}});
  const auto shift = static_cast<std::uint32_t>(two.points.size());
  two.points.insert(two.points.end(), other.points.begin(), other.points.end());
  for (const auto& t : other.tets)
    two.tets.push_back({t[0] + shift, t[1] + shift, t[2] + shift, t[3] + shift});
  const std::vector<SpreadSize> sizes =
      spread_sizes(two, std::vector<SizeSource>{{vertex_at(two, {1, 0, 0}), 0.01, 0.3}});
  for (std::uint32_t v = 0; v < sizes.size(); ++v) EXPECT_EQ(std::isfinite(sizes[v].size), v < shift);
}

}  // namespace
}  // namespace weft::meshing::spread_sizes_test
