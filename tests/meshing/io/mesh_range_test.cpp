// Ranges of mesh files: put together they are what the whole file is, in every format that knows them.
#include "meshing/io/mesh_file.h"
#include "meshing/mesh/structured_box.h"
#include "tests/meshing/io/format_support.h"

namespace weft::meshing::mesh_range_test {
namespace {

/// A box of two regions, with names.
MeshContents named_box() {
  MeshContents box;
  box.mesh = structured_box({{3, 2, 2}, {0, 0, 0}, {3, 2, 2}});
  for (std::size_t t = 0; t < box.mesh.tet_refs.size(); t += 3) box.mesh.tet_refs[t] = 5;
  box.names.set(2, 1, "inflow");
  box.names.set(3, 5, "solid");
  box.complete();
  return box;
}

/// The same with marks, which most formats drop.
MeshContents marked_box() {
  MeshContents box = named_box();
  box.mesh.ridges = {2, 0};
  box.mesh.required_edges = {3, 3, 1};
  box.mesh.required_triangles = {9, 4, 20, 1};
  box.mesh.required_points = {5, 1};
  return box;
}

template <class T>
void append(std::vector<T>& all, const std::vector<T>& part) {
  all.insert(all.end(), part.begin(), part.end());
}

/// The file in `parts` ranges, some of which are told what the whole has.
MeshContents read_in_parts(const fs::path& path, std::uint64_t parts) {
  const std::optional<MeshSize> size = size_for_ranges(path);
  if (!size) throw std::logic_error("no ranges of " + path.string());
  MeshContents all;
  for (std::uint64_t p = 0; p < parts; ++p) {
    const std::uint64_t point = size->points * p / parts, tet = size->tets * p / parts;
    const MeshContents part = read_mesh_range(
        path, {point, size->points * (p + 1) / parts - point, tet, size->tets * (p + 1) / parts - tet, p,
               parts, p % 2 == 0 ? size : std::nullopt});
    const MeshData& mesh = part.mesh;
    append(all.mesh.points, mesh.points), append(all.mesh.point_refs, mesh.point_refs);
    append(all.mesh.tets, mesh.tets), append(all.mesh.tet_refs, mesh.tet_refs);
    append(all.mesh.triangles, mesh.triangles), append(all.mesh.triangle_refs, mesh.triangle_refs);
    append(all.mesh.edges, mesh.edges), append(all.mesh.edge_refs, mesh.edge_refs);
    append(all.mesh.ridges, mesh.ridges);
    append(all.mesh.required_edges, mesh.required_edges);
    append(all.mesh.required_triangles, mesh.required_triangles);
    append(all.mesh.corners, mesh.corners);
    append(all.mesh.required_points, mesh.required_points);
    all.names = part.names;
    all.fields = part.fields;
  }
  return all;
}

class MeshRanges : public testing::TestWithParam<std::string> {
 protected:
  TemporaryDirectory directory;
};

TEST_P(MeshRanges, TogetherAreTheWholeFile) {
  const fs::path path = directory / GetParam();
  write_mesh_contents(path, marked_box());
  const MeshContents whole = read_mesh_contents(path);
  const bool slow = path.extension() == ".cgns";  // HDF5 opens the file for every part
  for (const std::uint64_t parts : {1u, 3u, 7u, slow ? 20u : 100u}) {
    const MeshContents read = read_in_parts(path, parts);
    expect_equal(read.mesh, whole.mesh);
    EXPECT_EQ(read.names.all(), whole.names.all());
    EXPECT_TRUE(read.fields.fields.empty());
  }
}

TEST_P(MeshRanges, OfAFileCutShortAreRefused) {
  const fs::path path = directory / GetParam();
  write_mesh_contents(path, named_box());
  const std::string bytes = bytes_of(path);
  for (const std::size_t length : {std::size_t{0}, std::size_t{10}, bytes.size() / 2, bytes.size() - 200}) {
    put_bytes(path, bytes.substr(0, length));
    EXPECT_THROW(read_in_parts(path, 3), InputError) << length;
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshRanges,
                         testing::Values("m.meshb", "m.mesh", "m.lb8.ugrid", "m.b8.ugrid", "m.b8l.ugrid",
                                         "m.lb4.ugrid", "m.cgns", "m.vtu", "m.msh"));

TEST(MeshRange, OfUgridNamesTheRowOfTheWholeFile) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "m.lb8.ugrid";
  MeshContents box = named_box();
  box.mesh.tets[40][2] = 1000;
  write_mesh_contents(path, box);
  EXPECT_NO_THROW(read_mesh_range(path, {0, 10, 0, 40}));
  EXPECT_EQ(message_of([&] {
              read_mesh_range(path, {0, 10, 30, 20});
            }),
            message_of([&] { read_mesh(path); }));
}

TEST(MeshRange, OfTrianglesNamesTheRowOfTheWholeFile) {
  const TemporaryDirectory directory;
  for (const char* name : {"m.lb8.ugrid", "m.meshb", "m.mesh", "m.msh", "m.vtu", "m.cgns"}) {
    SCOPED_TRACE(name);
    const fs::path path = directory / name;
    MeshContents box = named_box();
    const auto last = box.mesh.triangles.size() - 1;
    box.mesh.triangles[last][2] = 1000;
    write_mesh_contents(path, box);
    EXPECT_NO_THROW(read_mesh_range(path, {0, 10, 0, 20, 0, 2}));
    EXPECT_EQ(message_of([&] {
                read_mesh_range(path, {0, 10, 0, 20, 1, 2});
              }),
              message_of([&] { read_mesh(path); }));
  }
}

TEST(MeshRange, OfMshHasGroupsThatOnlyOthersHave) {
  const TemporaryDirectory directory;
  MeshContents box = named_box();
  for (std::size_t t = 0; t < box.mesh.triangles.size(); ++t) box.mesh.triangle_refs[t] = t < 8 ? 7 : 0;
  for (std::size_t t = 0; t < box.mesh.tets.size(); ++t) box.mesh.tet_refs[t] = t < 8 ? 7 : 0;
  write_mesh_contents(directory / "m.msh", box);
  const MeshContents whole = read_mesh_contents(directory / "m.msh");
  EXPECT_EQ(whole.mesh.triangle_refs.front(), 0);  // by references
  expect_equal(read_in_parts(directory / "m.msh", 5).mesh, whole.mesh);
}

TEST(MeshRange, IsNotReadOfFormatsWithoutPlaces) {
  const TemporaryDirectory directory;
  for (const char* name : {"m.ugrid", "m.su2"}) {
    write_mesh_contents(directory / name, named_box());
    EXPECT_FALSE(size_for_ranges(directory / name)) << name;
  }
}

TEST(MeshRange, OfVtuAsTextIsFoundByPassingOverRows) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "m.vtu";
  WriteOptions ascii;
  ascii.encoding = WriteOptions::Encoding::ascii;
  MeshContents box = named_box();
  box.mesh.point_refs[7] = 3;
  box.mesh.ridges.clear();  // which the format does not keep
  write_mesh_contents(path, box, ascii);
  const MeshContents whole = read_mesh_contents(path);
  expect_equal(whole.mesh, box.mesh);
  for (const std::uint64_t parts : {1u, 3u, 50u}) expect_equal(read_in_parts(path, parts).mesh, whole.mesh);
  std::string bytes = bytes_of(path);
  bytes.replace(bytes.find("<?xml"), 5, "<!-- <DataArray format=\"ascii\"> --><?xml");
  put_bytes(path, bytes);
  expect_equal(read_in_parts(path, 3).mesh, whole.mesh);  // what looks like an array in a comment is none
}

TEST(MeshRange, OfVtuIsReadHoweverItIsEncoded) {
  const TemporaryDirectory directory;
  std::vector<fs::path> files = {directory / "m.vtu"};
  write_mesh_contents(files[0], named_box(), {.compress = true});
  for (const char* name :
       {"vtk-box-inline.vtu", "vtk-box-inline-zlib.vtu", "vtk-box-base64.vtu", "vtk-box-base64-zlib.vtu",
        "vtk-box-raw-big-endian.vtu", "vtk-box-raw-zlib.vtu", "meshio-box.vtu"})
    files.push_back(sample(name));
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    const MeshContents whole = read_mesh_contents(file);
    for (const std::uint64_t parts : {1u, 3u, 50u}) expect_equal(read_in_parts(file, parts).mesh, whole.mesh);
    const std::uint64_t n = whole.mesh.points.size(), half = n / 2;
    const PieceRange ranges[] = {{{0, half, 0, 0}}, {{half, n - half, 0, 0}}};
    const SolutionData low = read_piece_fields(file, {&ranges[0], 1})[0].fields,
                       high = read_piece_fields(file, {&ranges[1], 1})[0].fields;
    ASSERT_EQ(low.fields.size(), whole.fields.fields.size());
    for (std::size_t f = 0; f < low.fields.size(); ++f) {
      std::vector<double> together = low.fields[f].values;
      append(together, high.fields[f].values);
      EXPECT_EQ(together, whole.fields.fields[f].values);
      EXPECT_EQ(low.fields[f].name, whole.fields.fields[f].name);
    }
  }
}

/// Names of boundary conditions take the place of sections', whoever reads which triangles.
TEST(MeshRange, OfCgnsHasTheNamesOfTheWholeFile) {
  const fs::path path = sample("cgns-mixed.cgns");
  const MeshContents whole = read_mesh_contents(path);
  for (const std::uint64_t parts : {1u, 2u, 5u, 13u}) {
    const MeshContents read = read_in_parts(path, parts);
    expect_equal(read.mesh, whole.mesh);
    EXPECT_EQ(read.names.all(), whole.names.all());
  }
}

/// Blocks of cells none of which a reader keeps are passed over, but for what the file's account says.
TEST(MeshRange, OfVtuTellsAllThatIsDropped) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "m.vtu";
  WriteOptions ascii;
  ascii.encoding = WriteOptions::Encoding::ascii;
  write_mesh_contents(path, named_box(), ascii);
  std::string bytes = bytes_of(path);
  const std::size_t types = bytes.find(">", bytes.find("Name=\"types\"")),
                    last = bytes.rfind('5', bytes.find("</", types));
  bytes[last] = '7';  // a triangle becomes a polygon
  put_bytes(path, bytes);
  const MeshContents whole = read_mesh_contents(path);
  ASSERT_EQ(whole.dropped.size(), 1u);
  EXPECT_EQ(whole.mesh.triangles.size(), named_box().mesh.triangles.size() - 1);
  expect_equal(read_in_parts(path, 4).mesh, whole.mesh);
  const MeshContents first = read_mesh_range(path, {0, 1, 0, 0, 0, 100});
  ASSERT_EQ(first.dropped.size(), 1u);
  EXPECT_EQ(first.dropped[0].what, whole.dropped[0].what);
  EXPECT_EQ(first.dropped[0].count, 1u);
}

TEST(MeshRange, IsNotReadOfTextOrOlderVersionsOfMsh) {
  const TemporaryDirectory directory;
  WriteOptions ascii, old;
  ascii.encoding = WriteOptions::Encoding::ascii;
  old.gmsh_version = 2;
  for (const WriteOptions& options : {ascii, old}) {
    write_mesh_contents(directory / "m.msh", named_box(), options);
    EXPECT_FALSE(size_for_ranges(directory / "m.msh"));
  }
}

TEST(MeshRange, WithForeignVolumesIsRefusedAsTheWholeFile) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "m.lb8.ugrid";
  std::string bytes;
  const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const int count : {5, 0, 0, 1, 1, 0, 0}) put(count);
  for (int c = 0; c < 15; ++c) put(double{1.5});
  for (const int v : {1, 2, 3, 4, 1, 2, 3, 4, 5}) put(v);
  put_bytes(path, bytes);
  EXPECT_EQ(message_of([&] { read_mesh_range(path, {0, 5, 0, 1}); }), message_of([&] { read_mesh(path); }));
}

}  // namespace
}  // namespace weft::meshing::mesh_range_test
