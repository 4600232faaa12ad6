// PVTU files: cutting and putting together again.
#include "meshing/io/vtk/pvtu.h"

#include "meshing/io/vtk/vtu.h"
#include "meshing/mesh/structured_box.h"
#include "tests/meshing/io/format_support.h"

namespace weft::meshing::pvtu_test {
namespace {

class Pvtu : public testing::Test {
 protected:
  /// A box with a field, and one point that no element uses.
  Pvtu() {
    box.mesh = structured_box({{3, 3, 3}, {0, 0, 0}, {1, 1, 1}});
    box.mesh.ridges.clear();
    box.mesh.points.push_back({5, 6, 7});
    box.mesh.point_refs.push_back(-3);
    Field field{Field::Kind::vector, {}, "position"};
    for (const Point& p : box.mesh.points) field.values.insert(field.values.end(), {p.x, p.y, p.z});
    box.fields = {box.mesh.points.size(), {field}};
  }
  void replace_in_pieces(const std::string& old, const std::string& with) const {
    for (const char* name : {"m_0.vtu", "m_1.vtu"}) {
      std::string text = bytes_of(directory / name);
      for (auto at = text.find(old); at != std::string::npos; at = text.find(old))
        text.replace(at, old.size(), with);
      put_bytes(directory / name, text);
    }
  }

  MeshContents box;
  TemporaryDirectory directory;
};

TEST_F(Pvtu, RoundTripWithGlobalIdsIsExact) {
  for (const int pieces : {1, 2, 5}) {
    write_pvtu(directory / "m.pvtu", box, {.pieces = pieces});
    const MeshContents read = read_pvtu(directory / "m.pvtu");
    expect_equal(read.mesh, box.mesh);
    expect_equal_fields(read.fields, box.fields);
  }
  EXPECT_EQ(directory.num_entries(), 6u);
}

TEST_F(Pvtu, AllPiecesAndTheIndexHaveReferencesOfPointsOrNone) {
  const auto expect_arrays = [&](int of_points) {
    write_pvtu(directory / "m.pvtu", box, {.pieces = 2});
    for (const char* name : {"m.pvtu", "m_0.vtu", "m_1.vtu"})
      EXPECT_EQ(count(bytes_of(directory / name), "type=\"Int32\" Name=\"ref\""), 1 + of_points) << name;
  };
  expect_arrays(1);  // one point has one, which is in the first piece
  box.mesh.point_refs.back() = 0;
  expect_arrays(0);
}

TEST_F(Pvtu, NamesOfArraysDifferAsInTheIndex) {
  box.fields.fields.push_back(box.fields.fields[0]);
  for (const char* name : {"ref", "GlobalPointIds"}) {
    box.fields.fields.push_back(box.fields.fields[0]);
    box.fields.fields.back().name = name;
  }
  write_pvtu(directory / "m.pvtu", box, {.pieces = 2});
  for (const char* file : {"m.pvtu", "m_0.vtu", "m_1.vtu"})
    for (const char* name : {"position", "position_2", "ref_2", "GlobalPointIds_2"})
      EXPECT_EQ(count(bytes_of(directory / file), " Name=\"" + std::string(name) + "\""), 1) << file << name;
  expect_equal(read_pvtu(directory / "m.pvtu").mesh, box.mesh);
}

TEST_F(Pvtu, OfAnEarlierVersionIsRead) {
  const MeshContents whole = read_vtu(sample("meshio-box.vtu")), read = read_pvtu(sample("weft-box.pvtu"));
  expect_equal(read.mesh, whole.mesh);
  expect_equal_fields(read.fields, whole.fields);
  EXPECT_EQ(pvtu_sources(sample("weft-box.pvtu")),
            (std::vector<fs::path>{sample("weft-box_0.vtu"), sample("weft-box_1.vtu")}));
}

TEST_F(Pvtu, WithoutIdsPointsMergeByTheirPlace) {
  write_pvtu(directory / "m.pvtu", box, {.encoding = WriteOptions::Encoding::ascii, .pieces = 2});
  replace_in_pieces("GlobalPointIds", "Numbers");
  replace_in_pieces(" GlobalIds=\"Numbers\"", "");
  const MeshContents read = read_pvtu(directory / "m.pvtu");
  EXPECT_EQ(read.mesh.points.size(), box.mesh.points.size());
  EXPECT_EQ(read.mesh.triangles.size(), box.mesh.triangles.size());
  EXPECT_EQ(read.mesh.corners.size(), 8u);
  EXPECT_NEAR(total_volume(read.mesh), 1, 1e-14);
  ASSERT_EQ(read.fields.fields.size(), 2u);
  for (std::size_t i = 0; i < read.mesh.points.size(); ++i) {
    EXPECT_EQ(read.fields.fields[1].values[3 * i + 1], read.mesh.points[i].y);
  }
}

TEST_F(Pvtu, GhostCellsAreLeftOut) {
  write_pvtu(directory / "m.pvtu", box, {.encoding = WriteOptions::Encoding::ascii, .pieces = 2});
  const MeshContents before = read_vtu(directory / "m_1.vtu");
  const std::size_t cells = before.mesh.tets.size() + before.mesh.triangles.size() +
                            before.mesh.edges.size() + before.mesh.corners.size();
  std::string ghosts = "<CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">1 2";
  for (std::size_t i = 2; i < cells; ++i) ghosts += " 0";
  std::string text = bytes_of(directory / "m_1.vtu");
  text.replace(text.find("<CellData"), text.find('>', text.find("<CellData")) - text.find("<CellData") + 1,
               ghosts + "</DataArray>");
  put_bytes(directory / "m_1.vtu", text);
  EXPECT_EQ(read_pvtu(directory / "m.pvtu").mesh.tets.size(), box.mesh.tets.size() - 1);
}

TEST_F(Pvtu, PiecesAgreeOnWhetherRealsAreReferences) {
  box.mesh.point_refs.back() = 0;
  write_pvtu(directory / "m.pvtu", box, {.encoding = WriteOptions::Encoding::ascii, .pieces = 2});
  replace_in_pieces("type=\"Int32\" Name=\"ref\"", "type=\"Float64\" Name=\"ref\"");
  EXPECT_EQ(read_pvtu(directory / "m.pvtu").mesh.triangle_refs, box.mesh.triangle_refs);
  std::string text = bytes_of(directory / "m_1.vtu");
  const auto first = text.find_first_of("0123456789", text.find('>', text.find("Name=\"ref\"")));
  put_bytes(directory / "m_1.vtu", text.replace(first, text.find_first_of(" \n<", first) - first, "0.5"));
  const MeshContents read = read_pvtu(directory / "m.pvtu");
  EXPECT_FALSE(has_refs(read.mesh.tet_refs) || has_refs(read.mesh.triangle_refs));
  EXPECT_TRUE(dropped(
      read, "values of cell data ref",
      box.mesh.tets.size() + box.mesh.triangles.size() + box.mesh.edges.size() + box.mesh.corners.size()));

  const PieceSize whole = vtu_piece_sizes(directory / "m_0.vtu")[0];
  EXPECT_EQ(whole.not_refs, 0);
  for (const std::uint8_t not_refs : {std::uint8_t{0}, vtu_piece_sizes(directory / "m_1.vtu")[0].not_refs}) {
    const PieceRange range{{0, whole.points, 0, whole.tets}, true, not_refs};
    const PieceRanges ranges = read_vtu_piece_ranges(directory / "m_0.vtu", {&range, 1});
    EXPECT_EQ(has_refs(ranges.pieces[0].contents.mesh.tet_refs), not_refs == 0);
  }
}

TEST_F(Pvtu, FieldsThatAPieceLacksAreDropped) {
  write_pvtu(directory / "m.pvtu", box, {.pieces = 2});
  MeshContents piece = read_vtu(directory / "m_1.vtu");
  piece.fields.fields[0].name = "velocity";
  write_vtu_piece(directory / "m_1.vtu", piece,
                  read_vtu_pieces(std::vector{directory / "m_1.vtu"})[0][0].global_ids, false, {});
  const MeshContents read = read_pvtu(directory / "m.pvtu");
  EXPECT_TRUE(read.fields.fields.empty());
  EXPECT_TRUE(dropped(read, "fields that some pieces lack", 2));
}

TEST_F(Pvtu, ErrorsNameThePiece) {
  const auto message = [&] { return message_of([&] { read_pvtu(directory / "m.pvtu"); }); };
  write_pvtu(directory / "m.pvtu", box, {});
  fs::remove(directory / "m_1.vtu");
  expect_contains(message(), "m_1.vtu: cannot read: No such file");
  put_bytes(directory / "m.pvtu", "<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid/></VTKFile>");
  expect_contains(message(), "m.pvtu: Piece: is missing");
  put_bytes(directory / "m.pvtu",
            "<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid><Piece/></PUnstructuredGrid></VTKFile>");
  expect_contains(message(), "m.pvtu: Piece: has no Source");
}

}  // namespace
}  // namespace weft::meshing::pvtu_test
