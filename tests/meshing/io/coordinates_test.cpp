// Coordinates that are not finite: refused, or passed on to be repaired, in every format that has tets.
#include <cmath>
#include <limits>

#include "meshing/io/mesh_file.h"
#include "meshing/mesh/repair/repair_mesh.h"
#include "meshing/mesh/structured_box.h"
#include "tests/meshing/io/format_support.h"

namespace weft::meshing::coordinates_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

struct FileKind {
  std::string name;
  WriteOptions options;
};

class CoordinatesOfFormats : public testing::TestWithParam<FileKind> {
 protected:
  fs::path write(const MeshData& mesh) const {
    const fs::path path = directory_ / GetParam().name;
    MeshContents contents;
    contents.mesh = mesh;
    contents.complete();
    write_mesh_contents(path, contents, GetParam().options);
    return path;
  }

 private:
  TemporaryDirectory directory_;
};

TEST_P(CoordinatesOfFormats, RefusedUnlessTheyAreWantedAndThenRemovedWhereNoTetHasThem) {
  const MeshData box = structured_box({{2, 2, 2}});
  MeshData bad = box;
  bad.points.push_back({kNaN, 9, kInfinity});
  bad.points.push_back({1, -kInfinity, 1});
  const fs::path path = write(bad);

  expect_contains(message_of([&] { read_mesh(path); }), "a coordinate is not finite");

  MeshData read = read_mesh(path, nullptr, Coordinates::any);
  ASSERT_EQ(read.points.size(), bad.points.size());
  EXPECT_FALSE(std::isfinite(read.points.back().y));
  const MeshRepair repair = repair_mesh(read);
  EXPECT_EQ(read.points, box.points);
  EXPECT_EQ(read.tets, box.tets);
  ASSERT_EQ(repair.mends.size(), 1u);
  EXPECT_EQ(repair.mends[0].what, "unused vertices removed");
  EXPECT_EQ(repair.mends[0].count, 2u);
}

TEST_P(CoordinatesOfFormats, AVertexOfATetIsRefusedByRepair) {
  MeshData bad = structured_box({{2, 2, 2}});
  bad.points[13].x = kNaN;
  MeshData read = read_mesh(write(bad), nullptr, Coordinates::any);
  expect_contains(message_of([&] { repair_mesh(read); }), "vertex 14: has a coordinate that is not finite");
}

std::string name_of(const testing::TestParamInfo<FileKind>& info) {
  std::string name = info.param.name;
  std::ranges::replace(name, '.', '_');
  return name + (info.param.options.encoding == WriteOptions::Encoding::ascii ? "_ascii" : "");
}

INSTANTIATE_TEST_SUITE_P(Io, CoordinatesOfFormats,
                         testing::Values(FileKind{"m.meshb", {}}, FileKind{"m.mesh", {}},
                                         FileKind{"m.su2", {}}, FileKind{"m.ugrid", {}},
                                         FileKind{"m.lb8.ugrid", {}}, FileKind{"m.msh", {}},
                                         FileKind{"m.msh", {.encoding = WriteOptions::Encoding::ascii}},
                                         FileKind{"m.vtu", {}},
                                         FileKind{"m.vtu", {.encoding = WriteOptions::Encoding::ascii}},
                                         FileKind{"m.pvtu", {}}, FileKind{"m.cgns", {}}),
                         name_of);

}  // namespace
}  // namespace weft::meshing::coordinates_test
