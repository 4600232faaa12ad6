// Meshes passed on while their files are read: in all formats the same as read whole, by a window of the
// file.
#include "meshing/io/files/mesh_stream.h"

#include <random>

#include "meshing/io/files/cursor.h"
#include "meshing/io/mesh_file.h"
#include "meshing/mesh/structured_box.h"
#include "tests/meshing/io/format_support.h"

namespace weft::meshing {
namespace {

/// More rows than a block, more bytes than a window of the file.
MeshContents large_box() {
  MeshContents box;
  box.mesh = structured_box({{24, 24, 24}, {0, 0, 0}, {1.1, 0.9, 1}});
  std::mt19937 random(3);
  for (std::int32_t& ref : box.mesh.tet_refs) ref = 1 + static_cast<std::int32_t>(random() % 3);
  box.names.set(2, 1, "inflow");
  box.complete();
  return box;
}

/// Counts blocks, and keeps what they bring.
class Counting final : public MeshStream {
 public:
  void take_points(std::vector<Point> rows) override { count(rows), kept_.take_points(std::move(rows)); }
  void take_point_refs(std::vector<std::int32_t> rows) override {
    count(rows), kept_.take_point_refs(std::move(rows));
  }
  void take_tets(std::vector<std::array<std::uint32_t, 4>> rows) override {
    count(rows), kept_.take_tets(std::move(rows));
  }
  void take_tet_refs(std::vector<std::int32_t> rows) override {
    count(rows), kept_.take_tet_refs(std::move(rows));
  }
  void take_other_tet_refs(std::vector<std::int32_t> rows) override {
    count(rows), kept_.take_other_tet_refs(std::move(rows));
  }
  void take_boundary(BoundaryRows rows) override {
    for_each_boundary_array([&](auto of_rows) { EXPECT_LE(of_rows(rows).size(), kRows); });
    ++boundary_blocks_;
    kept_.take_boundary(std::move(rows));
  }
  void prefer_other_refs(int dimension) override { kept_.prefer_other_refs(dimension); }
  void set_point_ref(std::uint32_t point, std::int32_t ref) override { kept_.set_point_ref(point, ref); }

  MeshCollector& kept() { return kept_; }
  std::size_t blocks() const { return blocks_; }
  std::size_t boundary_blocks() const { return boundary_blocks_; }

 private:
  template <class T>
  void count(const std::vector<T>& rows) {
    EXPECT_FALSE(rows.empty());
    EXPECT_LE(rows.size(), kRows);
    ++blocks_;
  }
  MeshCollector kept_;
  std::size_t blocks_ = 0, boundary_blocks_ = 0;
};

struct Streamed {
  MeshContents contents;
  std::size_t blocks, boundary_blocks;
};
Streamed streamed(const fs::path& path) {
  EXPECT_TRUE(can_be_streamed(path));
  Counting stream;
  Streamed s{stream_mesh(path, stream), 0, 0};
  const MeshData& kept = s.contents.mesh;
  EXPECT_TRUE(kept.points.empty() && kept.tets.empty() && kept.triangles.empty() &&
              kept.triangle_refs.empty() && kept.edges.empty() && kept.edge_refs.empty() &&
              kept.required_triangles.empty())
      << "kept beside the stream";
  stream.kept().put_into(s.contents.mesh);
  s.blocks = stream.blocks();
  s.boundary_blocks = stream.boundary_blocks();
  s.contents.complete();
  return s;
}

struct TextFormat {
  std::string name;
  bool ascii = false;
  int gmsh_version = 4;
};

class MeshStreams : public testing::TestWithParam<TextFormat> {
 protected:
  fs::path write(const MeshContents& contents) const {
    WriteOptions options;
    if (GetParam().ascii) options.encoding = WriteOptions::Encoding::ascii;
    options.gmsh_version = GetParam().gmsh_version;
    write_mesh_contents(directory / GetParam().name, contents, options);
    return directory / GetParam().name;
  }
  TemporaryDirectory directory;
};

TEST_P(MeshStreams, AreTheWholeFile) {
  for (const MeshContents& contents : {large_box(), full_contents()}) {
    const fs::path path = write(contents);
    RefNames names;
    const MeshData whole = read_mesh(path, &names);
    const Streamed s = streamed(path);
    expect_equal(s.contents.mesh, whole);
    EXPECT_EQ(s.contents.names.all(), names.all());
    EXPECT_EQ(whole.points, contents.mesh.points);
    if (whole.tets.size() > 1000) {
      EXPECT_GE(s.blocks, 3u) << "of tets there are two blocks";
    }
  }
}

/// A surface of more triangles than a block has rows, all of them required.
TEST_P(MeshStreams, PassTheBoundaryInBlocksToo) {
  MeshContents box = large_box();
  const std::size_t of_box = box.mesh.triangles.size(), count = 2 * MeshStream::kRows + 5;
  while (box.mesh.triangles.size() < count) {
    const std::size_t i = box.mesh.triangles.size();
    box.mesh.triangles.push_back(box.mesh.triangles[i % of_box]);
    box.mesh.triangle_refs.push_back(1 + static_cast<std::int32_t>(i % 7));
  }
  for (std::uint32_t i = 0; i < count; ++i) box.mesh.required_triangles.push_back(i);
  const fs::path path = write(box);
  const Streamed s = streamed(path);
  expect_equal(s.contents.mesh, read_mesh(path));
  EXPECT_EQ(s.contents.mesh.triangles.size(), count);
  EXPECT_GE(s.boundary_blocks, 3u);
}

TEST_P(MeshStreams, ComplainInTheWordsOfTheWholeFile) {
  MeshContents box = large_box();
  box.mesh.triangles[3000][1] = 900000;
  const std::string of_triangle = message_of([&] { read_mesh(write(box)); });
  EXPECT_NE(of_triangle, "");
  EXPECT_EQ(message_of([&] { streamed(directory / GetParam().name); }), of_triangle);
  box.mesh.tets[70000][1] = 900000;
  const fs::path path = write(box);
  const std::string says = message_of([&] { read_mesh(path); });
  expect_contains(says, GetParam().name == "m.msh" ? "node 900001 does not exist" : "out of range");
  EXPECT_EQ(message_of([&] { streamed(path); }), says);
  const std::string bytes = bytes_of(path);
  for (const std::size_t length : {std::size_t{20}, bytes.size() / 3, bytes.size() * 3 / 4}) {
    put_bytes(path, bytes.substr(0, length));
    const std::string cut = message_of([&] { read_mesh(path); });
    EXPECT_NE(cut, "");
    EXPECT_EQ(message_of([&] { streamed(path); }), cut) << length;
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshStreams,
                         testing::Values(TextFormat{"m.mesh"}, TextFormat{"m.su2"}, TextFormat{"m.ugrid"},
                                         TextFormat{"m.msh", true}, TextFormat{"m.msh", true, 2},
                                         TextFormat{"m.msh", false, 2}),
                         [](const auto& format) { return "Case" + std::to_string(format.index); });

TEST(MeshStream, OfGmshTakesEntitiesWhereNoTetHasAGroup) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "m.msh";
  const std::string head =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n9 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n7 1 1 "
      "1\n$EndNodes\n$Elements\n";
  put_bytes(path, head + "3\n1 15 2 6 1 3\n2 4 2 0 31 9 2 3 4\n3 4 2 0 32 2 3 4 7\n$EndElements\n");
  const MeshContents c = streamed(path).contents;
  EXPECT_EQ(c.mesh.tet_refs, (std::vector<std::int32_t>{31, 32}));
  EXPECT_EQ(c.mesh.point_refs, (std::vector<std::int32_t>{0, 0, 6, 0, 0}));
  EXPECT_EQ(c.mesh.tets[1], (std::array<std::uint32_t, 4>{1, 2, 3, 4})) << "tags with gaps in any order";
  put_bytes(path, head + "2\n2 4 2 0 31 9 2 3 4\n3 4 2 8 32 2 3 4 7\n$EndElements\n");
  EXPECT_EQ(streamed(path).contents.mesh.tet_refs, (std::vector<std::int32_t>{0, 8}));
  put_bytes(path, head + "2\n2 4 2 6 31 9 2 3 4\n3 4 2 8 31 9 2 3 4\n$EndElements\n");
  EXPECT_EQ(streamed(path).contents.mesh.tet_refs, (std::vector<std::int32_t>{6})) << "in two groups";
}

TEST(MeshStream, IsNotOfFilesThatHaveRanges) {
  const TemporaryDirectory directory;
  for (const char* name : {"m.meshb", "m.lb8.ugrid", "m.msh", "m.cgns", "m.vtu"}) {
    write_mesh_contents(directory / name, full_contents());
    EXPECT_FALSE(can_be_streamed(directory / name)) << name;
  }
}

/// Words of all lengths, also longer than a block of the file, comments, and a place in it.
TEST(CursorWindow, ShowsWhatMemoryWould) {
  const TemporaryDirectory directory;
  std::string text;
  std::mt19937 random(5);
  while (text.size() < 5'000'000) {
    const unsigned kind = random() % 50;
    if (kind == 0) text += "# a comment " + std::string(random() % 3000, 'c') + "\n";
    text += std::string(kind == 1 && text.size() > 1'000'000 ? random() % 700'000 : 1 + random() % 9, 'w');
    text += random() % 3 == 0 ? "\r\n" : std::string(1 + random() % 4, ' ');
  }
  text += "last";
  put_bytes(directory / "text", text);
  const InputFile file(directory / "text");
  const std::string name = file.name();
  Cursor window(file), memory(name, text);
  for (Cursor* cursor : {&window, &memory}) cursor->set_comment('#');
  while (!memory.at_end()) {
    ASSERT_FALSE(window.at_end());
    const bool by_lines = random() % 5 == 0;
    const std::string expected(by_lines ? memory.line() : memory.word());
    ASSERT_EQ(by_lines ? window.line() : window.word(), expected);
    ASSERT_EQ(window.position(), memory.position());
    ASSERT_EQ(window.remaining(), memory.remaining());
  }
  EXPECT_TRUE(window.at_end());
  EXPECT_EQ(window.word(), "");
  for (const std::size_t place :
       {std::size_t{0}, text.size() - 4, std::size_t{1'500'000}, std::size_t{1'400'000}}) {
    window.seek(place), memory.seek(place);
    EXPECT_EQ(std::string(window.word()), std::string(memory.word())) << place;
  }
}

TEST(CursorWindow, FindsTextAcrossBlocks) {
  const TemporaryDirectory directory;
  for (const std::size_t place : {std::size_t{3}, (std::size_t{1} << 20) - 4, (std::size_t{2} << 20) - 1}) {
    std::string text(3'000'000, '.');
    text.replace(place, 8, "$EndHere");
    put_bytes(directory / "text", text);
    const InputFile file(directory / "text");
    Cursor in(file);
    ASSERT_TRUE(in.find("$EndHere")) << place;
    EXPECT_EQ(in.position(), place);
    in.seek(place + 1);
    EXPECT_FALSE(in.find("$EndHere"));
    EXPECT_EQ(in.position(), place + 1);
  }
}

}  // namespace
}  // namespace weft::meshing
