// CGNS files: round trips, what CGNS's own tools write, damage.
#include "meshing/io/cgns.h"

#include <map>
#include <set>

#include "tests/meshing/io/format_support.h"
#include "tests/support/repetitions.h"

/// CGNS and HDF5 forget what they had read of a damaged file; that is not for us to mend.
extern "C" const char* __lsan_default_suppressions();  // NOLINT: the name is the sanitizer's
extern "C" const char* __lsan_default_suppressions() { return "leak:libcgns\nleak:libhdf5\n"; }

namespace weft::meshing::cgns_test {
namespace {

class Cgns : public testing::Test {
 protected:
  TemporaryDirectory directory;
};

MeshData expected_of(const MeshData& mesh) {
  MeshData expected = sorted_by_ref(without_marks(mesh));
  expected.corners.clear();
  expected.point_refs.assign(mesh.points.size(), 0);
  return expected;
}

TEST_F(Cgns, RoundTripIsExact) {
  MeshContents c = full_contents();
  c.names = {};
  write_cgns(directory / "m.cgns", c);
  const MeshContents read = read_cgns(directory / "m.cgns");
  expect_equal(read.mesh, expected_of(c.mesh));
  expect_equal_fields(read.fields, c.fields);
  EXPECT_TRUE(read.dropped.empty());
  EXPECT_EQ(directory.num_entries(), 1u);
}

TEST_F(Cgns, NamesAreKept) {
  MeshContents c = full_contents();
  c.names.set(2, -13, "a/b");
  c.names.set(1, 21, "a name of more than thirty-two characters");
  write_cgns(directory / "m.cgns", c);
  const MeshContents read = read_cgns(directory / "m.cgns");
  EXPECT_EQ(read.mesh.triangle_refs, (std::vector<std::int32_t>{1, 2, 3}));  // -13, 11, 12
  EXPECT_EQ(read.names.name(2, 1), "a_b");
  EXPECT_EQ(read.names.name(2, 2), "wing");
  EXPECT_EQ(read.names.name(2, 3), "far field");
  EXPECT_EQ(read.mesh.tet_refs, (std::vector<std::int32_t>{-8, 1}));
  EXPECT_EQ(read.names.name(3, 1), "air");
  EXPECT_EQ(read.names.name(1, 1), "a name of more than thirty");
}

TEST_F(Cgns, FieldsStayWholeWhereTheirNamesBeginAlike) {
  using Kind = Field::Kind;
  const std::string inlet = "time_averaged_velocity_of_the_inlet",
                    outlet = "time_averaged_velocity_of_the_outlet";
  MeshContents c = full_contents();
  c.fields.fields.clear();
  const auto add = [&](Kind kind, const std::string& name) {
    const std::size_t components = kind == Kind::scalar ? 1 : kind == Kind::vector ? 3 : 6;
    const auto value = static_cast<double>(c.fields.fields.size());
    c.fields.fields.push_back({kind, std::vector<double>(components * c.mesh.points.size(), value), name});
  };
  for (const std::string& name : {inlet, outlet}) add(Kind::vector, name);
  for (const std::string& name : {inlet, outlet}) add(Kind::tensor, name);
  add(Kind::scalar, "uY");
  for (int i = 0; i < 2; ++i) add(Kind::vector, "u");
  write_cgns(directory / "m.cgns", c);
  const MeshContents read = read_cgns(directory / "m.cgns");
  ASSERT_EQ(read.fields.fields.size(), c.fields.fields.size());
  std::set<std::string> names;
  for (std::size_t i = 0; i < c.fields.fields.size(); ++i) {
    EXPECT_EQ(read.fields.fields[i].kind, c.fields.fields[i].kind) << i;
    EXPECT_EQ(read.fields.fields[i].values, c.fields.fields[i].values) << i;
    names.insert(read.fields.fields[i].name);
  }
  EXPECT_TRUE(names.contains("u_2") && names.contains("u_3") && names.contains("uY"));
}

/// 32 bytes are in the middle of a letter.
TEST_F(Cgns, NamesAreCutBetweenCharacters) {
  MeshContents c = full_contents();
  c.names.set(2, 11, "\u00e9aaaaaaaaaaaaaaaaaaaaaaaaaaaaa\u00e4b");
  c.fields.fields = {{Field::Kind::scalar, std::vector<double>(5, 1.5),
                      "\u0442\u0435\u043c\u043f\u0435\u0440\u0430\u0442\u0443\u0440\u0430 "
                      "\u0442\u043e\u0440\u043c\u043e\u0436"}};
  write_cgns(directory / "m.cgns", c);
  const MeshContents read = read_cgns(directory / "m.cgns");
  EXPECT_EQ(read.fields.fields.at(0).name,
            "\u0442\u0435\u043c\u043f\u0435\u0440\u0430\u0442\u0443\u0440\u0430 "
            "\u0442\u043e\u0440\u043c");
  std::set<std::string> names;
  for (const std::int32_t ref : read.mesh.triangle_refs) names.insert(read.names.name(2, ref));
  EXPECT_TRUE(names.contains("\u00e9aaaaaaaaaaaaaaaaaaaaaaaaaaaaa"));
}

TEST_F(Cgns, EmptyPartsAreNoProblem) {
  MeshContents c;
  c.mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  c.mesh.triangles = {{0, 1, 2}};
  c.mesh.triangle_refs = {4};
  c.complete();
  write_cgns(directory / "m.cgns", c);
  expect_equal(read_cgns(directory / "m.cgns").mesh, c.mesh);
}

TEST_F(Cgns, ErrorsNameTheFile) {
  const auto message = [&] { return message_of([&] { read_cgns(directory / "m.cgns"); }); };
  expect_contains(message(), "m.cgns: cannot read: No such file or directory");
  put_bytes(directory / "m.cgns", "what is this");
  expect_contains(message(), "m.cgns: not a CGNS file in HDF5");
  expect_contains(message_of([&] { write_cgns(directory / "none/m.cgns", full_contents()); }),
                  "No such file");
}

TEST_F(Cgns, WrongNumbersAreNamed) {
  MeshContents c = full_contents();
  c.mesh.tets[1][2] = 77;
  write_cgns(directory / "m.cgns", c);
  expect_contains(message_of([&] { read_cgns(directory / "m.cgns"); }),
                  "m.cgns: section tets_ref_-8, element 1: vertex index 78 is out of range 1..5");
  c = full_contents();
  c.mesh.points[3].y = std::numeric_limits<double>::quiet_NaN();
  write_cgns(directory / "m.cgns", c);
  expect_contains(message_of([&] { read_cgns(directory / "m.cgns"); }),
                  "point 4: a coordinate is not finite");
}

/// Some bytes will do: most of an HDF5 file is structure that the library checks, and each case takes
/// milliseconds.
TEST_F(Cgns, DamageIsRefusedOrHarmless) {
  write_cgns(directory / "m.cgns", full_contents());
  // Always another name: the library may keep a damaged file open.
  int number = 0;
  const auto message = [&](const std::string& damaged) {
    const fs::path path = directory / (std::to_string(++number) + ".cgns");
    put_bytes(path, damaged);
    const std::string text = message_of([&] { expect_in_range(read_cgns(path).mesh); });
    fs::remove(path);
    return text;
  };
  for (const fs::path& path : {directory / "m.cgns", sample("cgns-mixed.cgns")}) {
    const std::string bytes = bytes_of(path);
    for (std::size_t i = 0; i < bytes.size(); i += support::repetitions(604, 151)) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ (i % 2 == 0 ? 0xFF : 1));
      message(damaged);
    }
    for (std::size_t length = 0; length < bytes.size(); length += 997) {
      EXPECT_NE(message(bytes.substr(0, length)), "no error") << length;
    }
  }
}

TEST_F(Cgns, ZonesMergeWhereTheirPointsCoincide) {
  const fs::path path = sample("cgns-two-zones.cgns");  // two cubes, one upon the other
  const MeshContents c = read_cgns(path);
  EXPECT_EQ(c.mesh.points.size(), 12u);
  EXPECT_EQ(c.mesh.tets.size(), 12u);
  EXPECT_NEAR(total_volume(c.mesh), 2, 1e-14);
  EXPECT_EQ(c.names.name(3, c.mesh.tet_refs[0]), "fluid");
  EXPECT_EQ(c.names.name(3, c.mesh.tet_refs[11]), "solid");
  ASSERT_EQ(c.fields.fields.size(), 2u);
  EXPECT_EQ(c.fields.fields[0].name, "p");
  EXPECT_EQ(c.fields.fields[1].kind, Field::Kind::vector);
  EXPECT_TRUE(dropped(c, "fields that some pieces lack", 2));
  EXPECT_FALSE(cgns_size(path));
  const std::vector<PieceSize> sizes = cgns_piece_sizes(path);
  ASSERT_EQ(sizes.size(), 2u);
  EXPECT_EQ(sizes[1].points, 8u);
  EXPECT_EQ(sizes[1].tets, 6u);
  const PieceRange ranges[] = {{{6, 2, 0, 0}, false}, {{0, 1, 2, 3}, true}};
  const PieceRanges read = read_cgns_piece_ranges(path, ranges);
  EXPECT_EQ(read.names.all(), c.names.all());
  EXPECT_EQ(read.pieces[0].contents.mesh.points, (std::vector<Point>{{0, 1, 1}, {1, 1, 1}}));
  EXPECT_TRUE(read.pieces[0].contents.mesh.triangles.empty());
  EXPECT_EQ(read.pieces[1].contents.mesh.tets.size(), 3u);
  EXPECT_EQ(read.pieces[1].contents.mesh.tet_refs, std::vector<std::int32_t>(3, c.mesh.tet_refs[11]));
  EXPECT_EQ(read.pieces[1].contents.mesh.triangles.size(), 4u);
}

TEST_F(Cgns, SectionsOfMixedElementsAreRead) {
  const fs::path path = sample("cgns-mixed.cgns");  // a cube; triangles are in both of its sections
  const MeshContents c = read_cgns(path);
  EXPECT_EQ(c.mesh.tets.size(), 6u);
  EXPECT_NEAR(total_volume(c.mesh), 1, 1e-14);
  EXPECT_EQ(c.names.name(3, c.mesh.tet_refs[5]), "air");
  EXPECT_EQ(c.mesh.triangles.size(), 12u);
  std::map<std::string, int> triangles;
  for (const std::int32_t ref : c.mesh.triangle_refs) ++triangles[c.names.name(2, ref)];
  EXPECT_EQ(triangles, (std::map<std::string, int>{{"air", 4}, {"floor", 2}, {"walls", 6}}));
  EXPECT_EQ(c.mesh.edges, (std::vector<std::array<std::uint32_t, 2>>{{0, 1}}));
  EXPECT_TRUE(dropped(c, "elements QUAD_4", 1));
  const auto size = cgns_size(path);
  ASSERT_TRUE(size);
  EXPECT_EQ(size->points, 8u);
  EXPECT_EQ(size->tets, 6u);
}

/// The sample with another type of its first element.
std::string with_first_type(std::string bytes, std::int32_t type) {
  const std::int32_t quad[] = {7, 1, 2, 4, 3};  // the first element
  const std::size_t place = bytes.find(std::string(reinterpret_cast<const char*>(quad), sizeof quad));
  EXPECT_NE(place, std::string::npos);
  return bytes.replace(place, sizeof type, reinterpret_cast<const char*>(&type), sizeof type);
}

TEST_F(Cgns, DamagedSectionsOfMixedElementsAreNamed) {
  const std::string bytes = bytes_of(sample("cgns-mixed.cgns"));
  const auto issue = [&](std::int32_t type) {
    const fs::path path = directory / (std::to_string(type) + ".cgns");
    put_bytes(path, with_first_type(bytes, type));
    return message_of([&] { read_cgns(path); });
  };
  EXPECT_EQ(issue(7), "no error");
  expect_contains(issue(1000), "section walls, element 1: has an unknown type");
  expect_contains(issue(20), "section walls, element 1: has the unknown type 20");  // mixed itself
  expect_contains(issue(17), "section walls, element");  // a hexahedron, which is longer
}

TEST_F(Cgns, FilesOfItsTools) {
  const MeshContents c = read_cgns(sample("cgns-box.cgns"));
  EXPECT_EQ(c.mesh.points.size(), 14u);
  EXPECT_EQ(c.mesh.triangles.size(), 24u);
  EXPECT_NEAR(total_volume(c.mesh), 1, 1e-14);
}

}  // namespace
}  // namespace weft::meshing::cgns_test
