// SU2 meshes: round trips, what Gmsh writes, damage.
#include "meshing/io/su2.h"

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::su2_test {
namespace {

class Su2 : public testing::Test {
 protected:
  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.su2", text);
    return read_su2(directory / "m.su2");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }
  TemporaryDirectory directory;
};

constexpr const char* kPoints = "NPOIN= 4\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n";

TEST_F(Su2, RoundTripIsExact) {
  MeshContents c = full_contents();
  write_su2(directory / "m.su2", c);
  const MeshContents read = read_su2(directory / "m.su2");
  EXPECT_EQ(read.mesh.points, c.mesh.points);
  EXPECT_EQ(read.mesh.tets, c.mesh.tets);
  EXPECT_EQ(read.mesh.triangles, sorted_by_ref(c.mesh).triangles);
  EXPECT_EQ(read.mesh.triangle_refs, (std::vector<std::int32_t>{-13, 1, 2}));
  EXPECT_EQ(read.names.name(2, 1), "wing");
  EXPECT_EQ(read.names.name(2, 2), "far_field");
}

TEST_F(Su2, TagsThatWouldBecomeOneAreNumbered) {
  MeshContents c = full_contents();
  c.names.set(2, -13, "far=field");
  c.names.set(2, 11, "far_field");
  write_su2(directory / "m.su2", c);
  const MeshContents read = read_su2(directory / "m.su2");
  EXPECT_EQ(read.mesh.triangle_refs, (std::vector<std::int32_t>{1, 2, 3}));
  EXPECT_EQ(read.names.name(2, 1), "far_field");
  EXPECT_EQ(read.names.name(2, 2), "far_field_2");
  EXPECT_EQ(read.names.name(2, 3), "far_field_3");
}

TEST_F(Su2, PartsInAnyOrderWithComments) {
  const MeshContents c = read_text(std::string("% a comment\nNDIME=3 % three\n") + kPoints +
                                   "NMARK= 2\nMARKER_TAG= 7 % its number\nMARKER_ELEMS= 2\n5 0 2 1\n9 0 1 2 "
                                   "3\nMARKER_TAG= far\nMARKER_ELEMS= 1\n"
                                   "5 0 1 3 0\nSEND_RECV= 1\nFFD_NBOX= 1\nFFD_LEVEL= 0\n1 2 3\nNELEM= 2\n10 "
                                   "0 1 2 3\n% here too\n12 0 1 2 3 0 1 2 3 1\n");
  EXPECT_EQ(c.mesh.tets, (std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(c.mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 2, 1}, {0, 1, 3}}));
  EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{7, 1}));
  EXPECT_EQ(c.names.name(2, 1), "far");
  EXPECT_EQ(c.foreign_volumes, 1u);
  EXPECT_TRUE(dropped(c, "quadrilaterals in markers", 1));
  EXPECT_TRUE(dropped(c, "entries FFD_LEVEL", 1));
}

TEST_F(Su2, ErrorsNameTheEntity) {
  const std::string head = std::string("NDIME= 3\n") + kPoints;
  expect_contains(issue(head + "NELEM= 1\n10 0 1 2 4\n"),
                  "m.su2: NELEM 1: vertex index 4 is out of range 0..3");
  expect_contains(issue(head + "NELEM= 1\n10 0 1 2 -1\n"), "NELEM 1: vertex index -1 is out of range");
  expect_contains(issue(head + "NELEM= 1\n5 0 1 2\n"), "NELEM 1: triangles among the volume elements");
  expect_contains(issue(head + "NELEM= 1\n77 0 1 2\n"), "NELEM 1: element type 77 is unknown");
  expect_contains(issue(head + "NELEM= 3\n10 0 1 2 3\n"), "NELEM 2: expected an integer");
  expect_contains(issue(head + "NELEM= 0\n10 0 1 2 3\n"), "expected KEY= VALUE, found '10 0 1 2 3'");
  expect_contains(issue(head + "NELEM= 999999999999\n"), "NELEM: the file is truncated, or its count");
  expect_contains(issue(head + "NELEM= 0\nNMARK= 1\n"), "has 0 markers instead of 1");
  expect_contains(issue(head), "NELEM= is missing");
  expect_contains(issue(head + "NELEM= 0\n"), "NMARK= is missing");
  expect_contains(issue("NDIME= 2\n"), "NDIME: the mesh has '2' dimensions");
  expect_contains(issue("NZONE= 2\n"), "several zones");
  expect_contains(issue("NDIME= 3\nNPOIN= 1\n0 inf 0\n"), "NPOIN 1: a coordinate is not finite");
  expect_contains(issue(""), "not an SU2 mesh");
}

TEST_F(Su2, DamageIsRefusedOrHarmless) {
  write_su2(directory / "m.su2", full_contents());
  const std::string bytes = bytes_of(directory / "m.su2");
  damage_everywhere(directory / "m.su2", bytes, read_su2);
  // The last row's last node may lose digits or its line feed.
  truncate_everywhere(directory / "m.su2", bytes, read_su2, 2);
}

TEST_F(Su2, FilesOfGmsh) {
  const MeshContents c = read_su2(sample("gmsh-box.su2"));
  EXPECT_EQ(c.mesh.points.size(), 14u);
  EXPECT_EQ(c.mesh.triangles.size(), 24u);
  EXPECT_NEAR(total_volume(c.mesh), 1, 1e-14);
  EXPECT_EQ(c.names.name(2, 2), "other_sides");
}

}  // namespace
}  // namespace weft::meshing::su2_test
