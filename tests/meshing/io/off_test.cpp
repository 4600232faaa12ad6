// OFF files: round trips, what other programs write, damage.
#include "meshing/io/off.h"

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::off_test {
namespace {

class Off : public testing::Test {
 protected:
  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.off", text);
    return read_off(directory / "m.off");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }
  TemporaryDirectory directory;
};

using Triangles = std::vector<std::array<std::uint32_t, 3>>;
constexpr const char* kPoints = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

TEST_F(Off, RoundTripOfASurfaceIsExact) {
  MeshContents c;
  c.mesh = two_tets();
  c.mesh.triangles = {{1, 2, 4}, {4, 2, 0}};
  c.mesh.triangle_refs = {1, 2};
  write_off(directory / "m.off", c);
  const MeshContents read = read_off(directory / "m.off");
  ASSERT_EQ(read.mesh.triangles.size(), 2u);
  for (std::size_t t = 0; t < 2; ++t)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(read.mesh.points[read.mesh.triangles[t][k]], c.mesh.points[c.mesh.triangles[t][k]]);
  EXPECT_EQ(read.mesh.points.size(), 4u);
  EXPECT_TRUE(read.mesh.tets.empty());
}

TEST_F(Off, PolygonsAreCutAndEdgesKept) {
  const MeshContents c = read_text("OFF # a square\n4 2 0\n\n" + std::string(kPoints) + "4 0 1 2 3\n2 1 3\n");
  EXPECT_EQ(c.mesh.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(c.mesh.edges, (std::vector<std::array<std::uint32_t, 2>>{{1, 3}}));
}

TEST_F(Off, ColoursAreDropped) {
  const MeshContents c =
      read_text("COFF 3 1 3\n0 0 0 255 0 0 1\n1 0 0 0 0 0 1 # black\n0 1 0 .5 0 0 1\n3 0 1 2 0.1 0.2 0.3\n");
  EXPECT_EQ(c.mesh.triangles, (Triangles{{0, 1, 2}}));
  ASSERT_EQ(c.dropped.size(), 2u);
}

TEST_F(Off, TheKeywordMayBeMissing) {
  EXPECT_EQ(read_text("4 1 0\n" + std::string(kPoints) + "3 1 2 3\n").mesh.triangles, (Triangles{{1, 2, 3}}));
}

TEST_F(Off, DamageIsNamed) {
  const std::string points(kPoints);
  expect_contains(issue("OFF\n4 1 0\n" + points + "3 0 1 4\n"), "face 1");
  expect_contains(issue("OFF\n4 2 0\n" + points + "3 0 1 2\n"), "face 2");
  expect_contains(issue("OFF\n4 1 0\n" + points + "1 0 1 2\n"), "too few points");
  expect_contains(issue("OFF\n4 1 0\n0 0\n"), "truncated");
  expect_contains(issue("OFF BINARY\n"), "binary");
  expect_contains(issue("4OFF\n4 1 0\n"), "not an OFF file");
  expect_contains(issue("OFF\n2 1 0\n0 0 nan\n0 0 1\n3 0 1 0\n"), "not finite");
}

}  // namespace
}  // namespace weft::meshing::off_test
