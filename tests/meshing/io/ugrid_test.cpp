// UGRID files: round trips in every encoding, what another program writes, damage.
#include "meshing/io/ugrid.h"

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::ugrid_test {
namespace {

const std::vector<std::string> kNames = {"m.lb8.ugrid", "m.b8.ugrid", "m.lb8l.ugrid", "m.b8l.ugrid",
                                         "m.lb4.ugrid", "m.b4.ugrid", "m.ugrid"};

MeshContents contents(bool short_reals) {
  MeshContents c;
  c.mesh = without_marks(short_reals ? two_tets() : full_contents().mesh);
  c.mesh.edges.clear();
  c.mesh.edge_refs.clear();
  c.mesh.corners.clear();
  c.mesh.point_refs.assign(5, 0);
  return c;
}

class Ugrid : public testing::Test {
 protected:
  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.ugrid", text);
    return read_ugrid(directory / "m.ugrid");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }
  TemporaryDirectory directory;
};

constexpr const char* kPoints = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

TEST_F(Ugrid, RoundTripInEveryEncoding) {
  for (const std::string& name : kNames) {
    const MeshContents c = contents(name.find("b4") != std::string::npos);
    write_ugrid(directory / name, c);
    expect_equal(read_ugrid(directory / name).mesh, c.mesh);
  }
}

TEST_F(Ugrid, BinarySizesAreThoseOfTheFormat) {
  MeshContents c = contents(false);
  c.mesh.tet_refs = {0, 0};  // then there are no volume IDs
  write_ugrid(directory / "m.lb8.ugrid", c);
  EXPECT_EQ(fs::file_size(directory / "m.lb8.ugrid"), 7u * 4 + 5 * 24 + 3 * 12 + 3 * 4 + 2 * 16);
  write_ugrid(directory / "m.b8l.ugrid", c);
  EXPECT_EQ(fs::file_size(directory / "m.b8l.ugrid"), 7u * 8 + 5 * 24 + 3 * 24 + 3 * 8 + 2 * 32);
}

TEST_F(Ugrid, OtherElementsAreCounted) {
  const MeshContents c = read_text(std::string("4 1 1 1 1 1 1\n") + kPoints +
                                   "1 2 3\n1 2 3 4\n7 8\n1 2 3 4\n1 2 3 4 4\n1 2 3 4 4 4\n1 2 3 4 1 2 3 4\n");
  EXPECT_EQ(c.mesh.tets, (std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{7}));
  EXPECT_EQ(c.foreign_volumes, 3u);
  EXPECT_TRUE(dropped(c, "quadrilaterals", 1));
  EXPECT_TRUE(dropped(c, "pyramids", 1));
}

TEST_F(Ugrid, NamesComeFromTheMapbcBesideIt) {
  write_ugrid(directory / "m.lb8.ugrid", contents(false));
  put_bytes(directory / "m.mapbc", "2\n11 4000 the wing\n12 5000 far\n");
  const MeshContents c = read_ugrid(directory / "m.lb8.ugrid");
  EXPECT_EQ(c.names.name(2, 11), "the wing");
  EXPECT_EQ(c.names.name(2, 12), "far");
  EXPECT_TRUE(dropped(c, "boundary conditions of m.mapbc", 2));
  put_bytes(directory / "m.mapbc", "2\n11 4000 the wing\n12\n");
  expect_contains(message_of([&] { read_ugrid(directory / "m.lb8.ugrid"); }),
                  "m.mapbc: boundary 2: expected");
}

TEST_F(Ugrid, ErrorsNameTheEntity) {
  const std::string points = kPoints;
  expect_contains(issue("4 1 0 0 0 0 0\n" + points + "1 2 5\n1\n"),
                  "m.ugrid: triangle 1: vertex index 5 is out of range 1..4");
  expect_contains(issue("4 0 0 1 0 0 0\n" + points + "0 1 2 3\n"), "tet 1: vertex index 0 is out of range");
  expect_contains(issue("4 0 0 2 0 0 0\n" + points + "1 2 3 4\n"),
                  "tet 2: expected an integer, found the end of the file");
  expect_contains(issue("-4 0 0 2 0 0 0\n"), "header: a count is -4");
  expect_contains(issue("4 0 0 0 0 0 0\n0 0 0 0 nan 0 0 0 0 0 0 0"), "node 2: a coordinate is not finite");
  expect_contains(issue("4 0 0 1 0 0 0\n" + points + "1 2 3 4\n0\n1 9\n"), "more in the file");
  expect_contains(issue(""), "header: expected an integer, found the end of the file");
  expect_contains(message_of([] { read_ugrid("x.r8.ugrid"); }), "Fortran records (.r8)");
  MeshContents c = contents(false);
  expect_contains(message_of([&] { write_ugrid(directory / "m.b4.ugrid", c); }),
                  "a coordinate is too large for 32-bit reals");
}

TEST_F(Ugrid, DamageIsRefusedOrHarmless) {
  for (const std::string& name : kNames) {
    MeshContents c = contents(name.find("b4") != std::string::npos);
    write_ugrid(directory / name, c);
    damage_everywhere(directory / name, bytes_of(directory / name), read_ugrid);
    c.mesh.tet_refs = {0, 0};
    write_ugrid(directory / name, c);
    const std::string bytes = bytes_of(directory / name);
    truncate_everywhere(directory / name, bytes, read_ugrid, name == "m.ugrid" ? 1 : 0);
  }
}

TEST_F(Ugrid, FilesOfAnotherProgram) {
  for (const char* name : {"meshio-box.lb8.ugrid", "meshio-box.b8.ugrid", "meshio-box.ugrid"}) {
    const MeshContents c = read_ugrid(sample(name));
    EXPECT_EQ(c.mesh.points.size(), 14u) << name;
    EXPECT_EQ(c.mesh.triangles.size(), 24u);
    EXPECT_NEAR(total_volume(c.mesh), 1, 1e-14);
  }
}

}  // namespace
}  // namespace weft::meshing::ugrid_test
