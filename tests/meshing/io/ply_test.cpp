// PLY files: round trips in every encoding, what other programs write, damage.
#include "meshing/io/ply.h"

#include <limits>

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::ply_test {
namespace {

using Encoding = WriteOptions::Encoding;

class Ply : public testing::Test {
 protected:
  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.ply", text);
    return read_ply(directory / "m.ply");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }
  TemporaryDirectory directory;
};

MeshContents surface() {
  MeshContents c = full_contents();
  c.mesh.tets.clear();
  c.mesh.tet_refs.clear();
  return c;
}

std::string ascii_file(const std::string& counts, const std::string& body) {
  return "ply\nformat ascii 1.0\n" + counts + "end_header\n" + body;
}
constexpr const char* kVertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
constexpr const char* kFaces = "element face 1\nproperty list uchar int vertex_index\n";
constexpr const char* kThreePoints = "0 0 0\n1 0 0\n0 1 0\n";

TEST_F(Ply, RoundTripIsExactInEveryEncoding) {
  for (const Encoding encoding : {Encoding::binary, Encoding::ascii, Encoding::big_endian}) {
    write_ply(directory / "m.ply", surface(), {.encoding = encoding});
    const MeshContents read = read_ply(directory / "m.ply");
    MeshData expected = surface().mesh;
    expected.corners.clear();
    expected.ridges.clear();
    expected.required_points.clear();
    expected.required_edges.clear();
    expected.required_triangles.clear();
    expect_equal(read.mesh, expected);
    ASSERT_EQ(read.fields.fields.size(), 1u);
    EXPECT_EQ(read.fields.fields[0].name, "field_of_1");
    EXPECT_EQ(read.fields.fields[0].values, surface().fields.fields[0].values);
  }
}

TEST_F(Ply, ForeignProperties) {
  const MeshContents c = read_text(ascii_file(
      "comment by hand\nelement vertex 4\nproperty float x\nproperty float nx\nproperty float y\nproperty "
      "uchar red\n"
      "property float z\nproperty float quality\nelement extra 2\nproperty list uchar float stuff\n"
      "element face 2\nproperty uchar flags\nproperty list uchar uint vertex_indices\n",
      "0 9 0 255 0 0.5\n1 9 0 255 0 1.5\n1 9 1 255 0 2.5\n0 9 1 255 0 3.5\n2 0.5 0.5\n0\n7 3 0 1 2\n7 4 0 1 "
      "2 3\n"));
  EXPECT_EQ(c.mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(c.mesh.points[2], (Point{1, 1, 0}));
  ASSERT_EQ(c.fields.fields.size(), 1u);
  EXPECT_EQ(c.fields.fields[0].values, (std::vector<double>{0.5, 1.5, 2.5, 3.5}));
  EXPECT_TRUE(dropped(c, "values of property nx", 4));
  EXPECT_TRUE(dropped(c, "values of property red", 4));
  EXPECT_TRUE(dropped(c, "values of property flags", 2));
  EXPECT_TRUE(dropped(c, "elements extra", 2));
  EXPECT_TRUE(dropped(c, "polygons (cut into triangles)", 1));
}

TEST_F(Ply, FacesWithASecondList) {
  const MeshContents c = read_text(ascii_file(
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n",
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n3 0 2 1 0\n"));
  EXPECT_EQ(c.mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 1}}));
  EXPECT_TRUE(dropped(c, "values of property texcoord", 2));
}

TEST_F(Ply, ErrorsNameTheRow) {
  const auto with_face = [&](const std::string& face) {
    return issue(ascii_file(std::string(kVertices) + kFaces, kThreePoints + face));
  };
  EXPECT_EQ(with_face("3 0 1 2\n"), "no error");
  expect_contains(with_face("3 0 1 3\n"), "m.ply: face 1: vertex index 3 is out of range 0..2");
  expect_contains(with_face("3 0 1 -1\n"), "face 1: vertex index -1 is out of range");
  expect_contains(with_face("3 0 1 0.5\n"), "face 1: expected an integer");
  expect_contains(with_face("2 0 1\n"), "face 1: has fewer than three corners");
  expect_contains(with_face("-3 0 1\n"), "face 1: a list's count is negative");
  expect_contains(with_face("9999999 0 1\n"), "face 1: the file is truncated, or its count");
  expect_contains(with_face("3 0 1 2\n3 0 1 2\n"), "more in the file than the header's counts say");
  expect_contains(issue(ascii_file(kVertices, "0 0 0\n1 nan 0\n0 1 0\n")),
                  "vertex 2: a coordinate is not finite");
  expect_contains(issue(ascii_file("element vertex 3\nproperty float x\n", "0\n0\n0\n")),
                  "no properties x, y and z");
  expect_contains(issue(ascii_file("element vertex 4000000000\n", "")), "vertex: has no properties");
  expect_contains(issue(ascii_file("element vertex 4000000000\nproperty float x\n", "")),
                  "vertex: the file is truncated, or its count of 4000000000 is wrong");
  expect_contains(issue(ascii_file("element vertex -4\n", "")), "header: the count -4 is negative");
  expect_contains(issue("ply\nformat ascii 1.0\n"), "no end_header");
  expect_contains(issue("ply\nformat utf8 1.0\nend_header\n"), "unknown format 'utf8'");
  expect_contains(issue("solid"), "not a PLY file");
}

TEST_F(Ply, DamageIsRefusedOrHarmless) {
  for (const Encoding encoding : {Encoding::binary, Encoding::ascii, Encoding::big_endian}) {
    write_ply(directory / "m.ply", surface(), {.encoding = encoding});
    const std::string bytes = bytes_of(directory / "m.ply");
    damage_everywhere(directory / "m.ply", bytes, read_ply);
    // The last number of a text may lose digits and still be one.
    truncate_everywhere(directory / "m.ply", bytes, read_ply, encoding == Encoding::ascii ? 3 : 0);
  }
}

TEST_F(Ply, FilesOfOtherPrograms) {
  for (const char* name :
       {"vtk-tetrahedron.ply", "vtk-tetrahedron-ascii.ply", "vtk-tetrahedron-big-endian.ply"}) {
    const MeshContents c = read_ply(sample(name));
    EXPECT_EQ(c.mesh.points.size(), c.mesh.triangles.size() / 2 + 2) << name;
  }
}

}  // namespace
}  // namespace weft::meshing::ply_test
