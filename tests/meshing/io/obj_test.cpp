// OBJ files: round trips, what other programs write, damage.
#include "meshing/io/obj.h"

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::obj_test {
namespace {

class Obj : public testing::Test {
 protected:
  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.obj", text);
    return read_obj(directory / "m.obj");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }
  TemporaryDirectory directory;
};

constexpr const char* kPoints = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

TEST_F(Obj, RoundTripIsExact) {
  MeshContents c = full_contents();
  c.mesh.tets.clear();
  c.mesh.tet_refs.clear();
  write_obj(directory / "m.obj", c);
  const MeshContents read = read_obj(directory / "m.obj");
  EXPECT_EQ(read.mesh.points, c.mesh.points);
  EXPECT_EQ(read.mesh.triangles,
            (std::vector<std::array<std::uint32_t, 3>>{{0, 2, 3}, {0, 1, 2}, {1, 2, 4}}));
  EXPECT_EQ(read.mesh.triangle_refs, (std::vector<std::int32_t>{-13, 1, 2}));
  EXPECT_EQ(read.names.name(2, 1), "wing");
  EXPECT_EQ(read.names.name(2, 2), "far field");
  EXPECT_EQ(read.mesh.edges, (std::vector<std::array<std::uint32_t, 2>>{{1, 2}, {0, 1}}));
  EXPECT_EQ(read.mesh.edge_refs, (std::vector<std::int32_t>{-22, 21}));
}

TEST_F(Obj, WritesOnlyThePointsOfAVolumesSurface) {
  MeshContents c;
  c.mesh = two_tets();
  c.mesh.triangles = {{1, 2, 4}};
  c.mesh.triangle_refs = {1};
  c.mesh.edges.clear();
  c.mesh.edge_refs.clear();
  write_obj(directory / "m.obj", c);
  const MeshContents read = read_obj(directory / "m.obj");
  EXPECT_EQ(read.mesh.points, (std::vector<Point>{{1, 0, 0}, {0, 1, 0}, {1, 1, 1.5}}));
}

TEST_F(Obj, LinesContinueBehindABackslash) {
  const MeshContents c = read_text(
      "# saved to C:\\models\\\nv 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nv 0 \\\r\n 0 \\\n1\nf 1 2 \\  \n 3\nf 1 2 "
      "4\\");
  EXPECT_EQ(c.mesh.points, (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_EQ(c.mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 1, 3}}));
  expect_contains(issue(std::string(kPoints) + "f 1 \\\n 2 x\n"), "line 6");
}

TEST_F(Obj, AllKindsOfFaces) {
  const MeshContents c =
      read_text(std::string(kPoints) +
                "vt 0 0\nvn 0 0 1\no thing\nf 1/1 2/1 3/1\ns off\nusemtl red\n"
                "f -1 -2 -3 -4 # a polygon\nf 1//1 2//1 4//1\ng part\nf 1/1/1 2/1/1 3/1/1\n");
  EXPECT_EQ(c.mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{
                                  {0, 1, 2}, {3, 2, 1}, {3, 1, 0}, {0, 1, 3}, {0, 1, 2}}));
  EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{1, 1, 1, 1, 2}));
  EXPECT_EQ(c.names.name(2, 1), "thing");
  EXPECT_EQ(c.names.name(2, 2), "part");
  EXPECT_TRUE(dropped(c, "polygons (cut into triangles)", 1));
  EXPECT_TRUE(dropped(c, "texture coordinates", 1));
  EXPECT_TRUE(dropped(c, "normals", 1));
  EXPECT_TRUE(dropped(c, "uses of materials", 1));
}

TEST_F(Obj, ErrorsNameTheLine) {
  expect_contains(issue(std::string(kPoints) + "f 1 2 5\n"), "m.obj: line 5: vertex index 5 is out of range");
  expect_contains(issue(std::string(kPoints) + "f 1 2 0\n"), "line 5: vertex index 0 is out of range");
  expect_contains(issue(std::string(kPoints) + "f 1 2 -5\n"), "line 5: vertex index -5 is out of range");
  expect_contains(issue(std::string(kPoints) + "f 1 2\n"), "line 5: has too few points");
  expect_contains(issue("v 0 0 inf\n"), "line 1: a coordinate is not finite");
  expect_contains(issue("v 0 0\n"), "line 1: expected three coordinates");
  expect_contains(issue("ply\n"), "line 1: begins with 'ply'");
  expect_contains(issue(""), "not an OBJ file");
}

TEST_F(Obj, DamageIsRefusedOrHarmless) {
  write_obj(directory / "m.obj", full_contents());
  const std::string bytes = bytes_of(directory / "m.obj");
  damage_everywhere(directory / "m.obj", bytes, read_obj);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    issue(bytes.substr(0, length));  // the format has no end that could be missing
  }
}

TEST_F(Obj, FilesOfOtherPrograms) {
  const MeshContents c = read_obj(sample("meshio-tetrahedron.obj"));
  EXPECT_EQ(c.mesh.points.size(), 4u);
  EXPECT_EQ(c.mesh.triangles.size(), 4u);
}

}  // namespace
}  // namespace weft::meshing::obj_test
