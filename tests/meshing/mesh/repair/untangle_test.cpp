// Vertices of inverted tets find a place where none is inverted.
#include "meshing/mesh/repair/untangle.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "meshing/mesh/repair/signed_tets.h"
#include "meshing/mesh/structured_box.h"

namespace weft::meshing::untangle_test {
namespace {

TEST(Untangle, RidgesDoNotGoToVerticesThatAreNone) {
  MeshData box = structured_box({{2, 2, 2}, {0, 0, 0}, {1, 1, 1}});
  const auto at = std::ranges::find(box.points, Point{1, 1, 0.5});
  ASSERT_NE(at, box.points.end());
  *at = {0.3, 0.45, 0.5};
  const auto vertex = static_cast<std::uint32_t>(at - box.points.begin());
  box.triangles.insert(box.triangles.end(), {{vertex, 0, 0xFFFFFFFFu}, {vertex, 1, 0xFFFFFFFFu}});
  box.triangle_refs.insert(box.triangle_refs.end(), {77, 78});
  ASSERT_FALSE(tets_not_positive(box).empty());
  EXPECT_FALSE(untangle(box, VertexGroup::ridge).empty());
  EXPECT_TRUE(tets_not_positive(box).empty());
}

}  // namespace
}  // namespace weft::meshing::untangle_test
