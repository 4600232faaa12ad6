// STL files: round trips, what other programs write, damage.
#include "meshing/io/stl.h"

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::stl_test {
namespace {

constexpr WriteOptions kAscii = {.encoding = WriteOptions::Encoding::ascii};

/// A tetrahedron's surface whose coordinates fit 32 bits.
MeshContents surface() {
  MeshContents c;
  c.mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1.5, 0}, {0, 0, 0.25}};
  c.mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
  c.mesh.triangle_refs = {3, 5, 3, 65535};
  c.complete();
  return c;
}

/// The coordinates of every triangle, whatever its points are numbered, with its reference.
std::vector<std::pair<std::array<Point, 3>, std::int32_t>> triangles_of(const MeshData& mesh) {
  std::vector<std::pair<std::array<Point, 3>, std::int32_t>> result;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    result.push_back({{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]}, mesh.triangle_refs[i]});
  }
  return result;
}

std::string two_facets(const std::string& third_corner) {
  const std::string facet =
      " facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex " + third_corner +
      "\n  endloop\n endfacet\n";
  return "solid part\n" + facet + facet + "endsolid part\n";
}

class Stl : public testing::Test {
 protected:
  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.stl", text);
    return read_stl(directory / "m.stl");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }
  TemporaryDirectory directory;
};

TEST_F(Stl, BinaryRoundTrip) {
  write_stl(directory / "m.stl", surface());
  EXPECT_EQ(fs::file_size(directory / "m.stl"), 84u + 4 * 50);
  const MeshContents read = read_stl(directory / "m.stl");
  EXPECT_EQ(read.mesh.points.size(), 4u);
  EXPECT_EQ(triangles_of(read.mesh), triangles_of(surface().mesh));
}

TEST_F(Stl, AsciiRoundTripIsExactAndKeepsNames) {
  MeshContents c = surface();
  c.mesh.points[1] = {1.0 / 3, 1e-300, -1e300};
  c.names.set(2, 3, "the wing");
  write_stl(directory / "m.stl", c, kAscii);
  const MeshContents read = read_stl(directory / "m.stl");
  EXPECT_EQ(read.names.name(2, 1), "the wing");
  auto expected = triangles_of(c.mesh);
  std::ranges::stable_sort(expected, {}, [](const auto& t) { return t.second; });
  for (auto& [corners, ref] : expected) ref = ref == 3 ? 1 : ref;  // named solids are numbered anew
  EXPECT_EQ(triangles_of(read.mesh), expected);
}

TEST_F(Stl, WritesOnlyTheTrianglesOfAVolume) {
  MeshContents c;
  c.mesh = two_tets();
  write_stl(directory / "m.stl", c);
  EXPECT_EQ(read_stl(directory / "m.stl").mesh.triangles.size(), 3u);
}

TEST_F(Stl, ABinaryTitleMayBeginWithSolid) {
  write_stl(directory / "m.stl", surface());
  std::string bytes = bytes_of(directory / "m.stl");
  bytes.replace(0, 6, "solid ");
  EXPECT_EQ(read_text(bytes).mesh.triangles.size(), 4u);
}

TEST_F(Stl, MergesEqualPointsAndDropsDegenerateTriangles) {
  const MeshContents merged = read_text(two_facets("-0.0 1 0"));
  EXPECT_EQ(merged.mesh.points.size(), 3u);
  EXPECT_EQ(merged.mesh.triangles.size(), 2u);
  const MeshContents flat = read_text(two_facets("1 0 0"));
  EXPECT_TRUE(flat.mesh.triangles.empty());
  EXPECT_TRUE(dropped(flat, "triangles with two equal corners", 2));
}

TEST_F(Stl, ErrorsNameTheFacet) {
  expect_contains(issue(two_facets("0 nan 0")), "m.stl: Facet 1: a coordinate is not finite");
  expect_contains(issue(two_facets("0 x 0")), "Facet 1: expected a number, found 'x'");
  expect_contains(issue(two_facets("0 1")), "Facet 1: expected a number, found 'endloop'");
  expect_contains(issue("what"), "not an STL file");
  expect_contains(issue(""), "not an STL file");
  MeshContents c = surface();
  c.mesh.points[0].x = 1e300;
  expect_contains(message_of([&] { write_stl(directory / "m.stl", c); }), "too large for the 32-bit reals");
}

TEST_F(Stl, DamageIsRefusedOrHarmless) {
  for (const WriteOptions& options : {WriteOptions{}, kAscii}) {
    write_stl(directory / "m.stl", surface(), options);
    const std::string bytes = bytes_of(directory / "m.stl");
    damage_everywhere(directory / "m.stl", bytes, read_stl);
    // What is optional is the name behind the last endsolid.
    const bool ascii = options.encoding == WriteOptions::Encoding::ascii;
    if (!ascii) truncate_everywhere(directory / "m.stl", bytes, read_stl);
  }
  write_stl(directory / "m.stl", surface(), kAscii);
  const std::string text = bytes_of(directory / "m.stl");
  for (std::size_t length = 0; length < text.size(); ++length) {
    issue(text.substr(0, length));  // whole solids may remain
  }
}

TEST_F(Stl, FilesOfOtherPrograms) {
  for (const char* name : {"gmsh-box.stl", "gmsh-box-binary.stl", "vtk-tetrahedron.stl"}) {
    const MeshContents c = read_stl(sample(name));
    EXPECT_TRUE(c.dropped.empty()) << name;
    // A closed surface: as many points as Euler says.
    EXPECT_EQ(c.mesh.points.size(), c.mesh.triangles.size() / 2 + 2) << name;
  }
}

}  // namespace
}  // namespace weft::meshing::stl_test
