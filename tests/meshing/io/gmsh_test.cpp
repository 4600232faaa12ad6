// MSH files: round trips in both versions and encodings, what Gmsh writes, damage.
#include "meshing/io/gmsh/gmsh.h"

#include <algorithm>
#include <limits>

#include "meshing/io/gmsh/gmsh_writer.h"
#include "tests/meshing/io/format_support.h"

namespace weft::meshing::gmsh_test {
namespace {

using Encoding = WriteOptions::Encoding;

const std::vector<WriteOptions> kVariants = {{.encoding = Encoding::binary, .gmsh_version = 4},
                                             {.encoding = Encoding::ascii, .gmsh_version = 4},
                                             {.encoding = Encoding::binary, .gmsh_version = 2},
                                             {.encoding = Encoding::ascii, .gmsh_version = 2}};

/// A 2.2 file with three points, by hand.
std::string by_hand(const std::string& elements,
                    const std::string& nodes = "3\n7 0 0 0\n1 1 0 0\n100 0 1 0\n") {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + nodes + "$EndNodes\n$Elements\n" + elements +
         "$EndElements\n";
}

std::string by_hand_4(const std::string& elements, const std::string& nodes,
                      const std::string& sections = "") {
  return "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + sections + "$Nodes\n" + nodes + "$EndNodes\n$Elements\n" +
         elements + "$EndElements\n";
}
constexpr const char* kNodes4 = "1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n";

class Gmsh : public testing::Test {
 protected:
  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.msh", text);
    return read_gmsh(directory / "m.msh");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }
  TemporaryDirectory directory;
};

TEST_F(Gmsh, RoundTripIsExactInEveryVariant) {
  const MeshContents c = full_contents();
  for (const WriteOptions& options : kVariants) {
    write_gmsh(directory / "m.msh", c, options);
    const MeshContents read = read_gmsh(directory / "m.msh");
    const MeshData expected = without_marks(c.mesh);
    expect_equal(read.mesh, options.gmsh_version == 4 ? sorted_by_ref(expected) : expected);
    expect_equal_fields(read.fields, c.fields);
    EXPECT_EQ(read.names.all(), c.names.all());
    EXPECT_TRUE(read.dropped.empty());
  }
}

TEST_F(Gmsh, WithoutGroupsReferencesAreTheEntities) {
  const MeshContents c = read_text(by_hand("2\n1 2 2 0 5 7 1 100\n2 1 2 0 6 1 100\n"));
  EXPECT_EQ(c.mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}}));
  EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{5}));
  EXPECT_EQ(c.mesh.edge_refs, (std::vector<std::int32_t>{6}));
}

TEST_F(Gmsh, OfElementsThatAreRepeatedForEachGroupTheFirstCounts) {
  const MeshContents c =
      read_text(by_hand("6\n1 2 2 3 1 7 1 100\n2 2 2 4 1 100 1 7\n"  // turned in its second group
                        "3 2 2 4 2 7 1 100\n4 2 2 4 2 7 1 100\n"     // the same twice in one group is a fault
                        "5 3 2 1 1 7 1 100 7\n6 3 2 2 1 7 1 100 7\n"));
  EXPECT_EQ(c.mesh.triangles.size(), 3u);
  EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{3, 4, 4}));
  EXPECT_TRUE(dropped(c, "quadrangles", 1));
  EXPECT_TRUE(dropped(c, "physical groups of entities that have several", 2));
}

TEST_F(Gmsh, GroupsLoseTheDirectionOfTheirEntities) {
  const std::string surface = " 0 0 0 1 1 0 1 ";
  const std::string elements = "3 3 1 3\n2 1 2 1\n1 1 2 3\n2 2 2 1\n2 1 2 3\n2 3 2 1\n3 1 2 3\n";
  const MeshContents c =
      read_text(by_hand_4(elements, kNodes4,
                          "$PhysicalNames\n3\n2 3 \"wall\"\n3 4 \"air\"\n2 -5 \"in\"\n$EndPhysicalNames\n"
                          "$Entities\n0 0 3 0\n1" +
                              surface + "-3 0\n2" + surface + "-4 0\n3" + surface + "-5 0\n$EndEntities\n"));
  EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{3, -4, -5}));
}

TEST_F(Gmsh, ANegativeReferenceBesideANameOfItsOppositeIsKept) {
  MeshContents c = full_contents();
  std::fill(c.mesh.triangle_refs.begin(), c.mesh.triangle_refs.end(), 3);
  c.mesh.triangle_refs[0] = -3;
  c.names = {};
  c.names.set(2, 3, "wall");
  write_gmsh(directory / "m.msh", c, kVariants[0]);
  const MeshContents read = read_gmsh(directory / "m.msh");
  EXPECT_EQ(std::ranges::count(read.mesh.triangle_refs, -3), 1);
  EXPECT_EQ(read.names.name(2, 3), "wall");
  EXPECT_EQ(read.names.name(2, -3), c.names.name(2, -3));
}

TEST_F(Gmsh, PartsOfEntitiesHaveTheirReferences) {
  const std::string elements = "3 3 1 3\n0 5 15 1\n1 1\n2 7 2 1\n2 1 2 3\n2 8 2 1\n3 1 2 3\n";
  const auto file = [&](const std::string& group, const std::string& of_volume) {
    return by_hand_4(elements, kNodes4,
                     "$Entities\n0 0 1 1\n9 0 0 0 1 1 0 " + group + " 0\n1 0 0 0 1 1 1 " + of_volume +
                         " 0\n$EndEntities\n$PartitionedEntities\n2\n1\n40 1\n1 0 2 0\n"
                         "5 2 9 2 1 2 0 0 0 " +
                         group +
                         "\n"
                         "7 2 9 1 1 0 0 0 1 1 0 " +
                         group +
                         " 0\n"
                         "8 3 1 2 1 2 0 0 0 1 1 0 " +
                         of_volume + " 0\n$EndPartitionedEntities\n");
  };
  for (const bool groups : {true, false}) {
    const MeshContents c = read_text(groups ? file("2 3 4", "1 10") : file("0", "0"));
    EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{groups ? 3 : 9}));
    EXPECT_TRUE(c.mesh.corners.empty());
    EXPECT_TRUE(dropped(c, "elements between partitions", 2));
    EXPECT_EQ(dropped(c, "physical groups of entities that have several", 1), groups);
    EXPECT_EQ(c.dropped.size(), groups ? 2u : 1u);
  }
}

TEST_F(Gmsh, TagsMayHaveGapsAndAnyOrder) {
  const MeshContents c =
      read_text(by_hand("1\n1 2 2 1 1 9 2 2000000000\n", "3\n2000000000 0 0 0\n9 1 0 0\n2 0 1 0\n"));
  EXPECT_EQ(c.mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{1, 2, 0}}));
}

TEST_F(Gmsh, OtherElementsAreCounted) {
  const MeshContents c =
      read_text(by_hand("3\n1 3 2 1 1 7 1 100 7\n2 3 2 1 1 7 1 100 7\n"
                        "3 5 2 1 1 7 1 100 7 7 7 7 7\n"));
  EXPECT_TRUE(dropped(c, "quadrangles", 2));
  EXPECT_TRUE(dropped(c, "hexahedra", 1));
  EXPECT_EQ(c.foreign_volumes, 1u);
}

TEST_F(Gmsh, OtherSectionsAreSkipped) {
  const std::string file = by_hand("0\n");
  const MeshContents c =
      read_text(file + "$Periodic\n1 2 3 $ 4\n$EndPeriodic\n$Comments\nhi\n$EndComments\n");
  EXPECT_TRUE(dropped(c, "sections $Periodic", 1));
  EXPECT_EQ(c.dropped.size(), 1u);
  expect_contains(issue(file + "$Periodic\n1 2 3\n"), "$Periodic: has no end");
}

TEST_F(Gmsh, ParametricNodesAreRead) {
  const MeshContents c = read_text(by_hand_4("1 1 1 1\n2 1 2 1\n1 1 2 3\n",
                                             "1 3 1 3\n2 1 1 3\n1\n2\n3\n0 0 0 9 9\n1 0 0 9 9\n0 1 0 9 9\n"));
  EXPECT_EQ(c.mesh.points[1], (Point{1, 0, 0}));
  EXPECT_EQ(c.mesh.points[2], (Point{0, 1, 0}));
}

TEST_F(Gmsh, PartialFieldsAreDropped) {
  const std::string head = "$NodeData\n1\n\"a\"\n1\n0\n3\n0\n1\n";
  EXPECT_TRUE(dropped(read_text(by_hand("0\n") + head + "2\n7 1.5\n1 2.5\n$EndNodeData\n"),
                      "fields without a value at every node", 1));
  EXPECT_EQ(
      read_text(by_hand("0\n") + head + "3\n1 2.5\n7 1.5\n100 3\n$EndNodeData\n").fields.fields[0].values,
      (std::vector<double>{1.5, 2.5, 3}));
}

TEST_F(Gmsh, ErrorsNameTheEntity) {
  expect_contains(issue(by_hand("1\n1 2 2 1 1 7 1 8\n")), "m.msh: element 1: node 8 does not exist");
  expect_contains(issue(by_hand("1\n1 77 2 1 1 7 1 8\n")), "element 1: element type 77 is unknown");
  expect_contains(issue(by_hand("1\n1 2 -2 1 1 7 1 8\n")), "element 1: a negative number of tags");
  expect_contains(issue(by_hand("2\n1 2 2 1 1 7 1 100\n")), "element 2: expected an integer, found '$EndEl");
  expect_contains(issue(by_hand("0\n1 2 2 1 1 7 1 100\n")), "$Elements: expected $EndElements, found '1'");
  expect_contains(issue(by_hand("900000000000\n")), "element: the file is truncated, or its count");
  expect_contains(issue(by_hand("0\n", "2\n1 0 0 0\n2 0 nan 0\n")), "node 2: a coordinate is not finite");
  expect_contains(issue(by_hand("0\n", "2\n1 0 0 0\n1 0 0 0\n")), "$Nodes: node 1 appears twice");
  expect_contains(issue(by_hand("0\n", "9000000000\n1 0 0 0\n")), "node: 9000000000 entities exceed");
  expect_contains(issue(by_hand_4("1 2 1 2\n2 1 2 1\n1 1 2 3\n", kNodes4)), "1 elements instead of 2");
  expect_contains(issue(by_hand_4("1 1 1 1\n3 1 2 1\n1 1 2 3\n", kNodes4)),
                  "triangles in an entity of dimension 3");
  expect_contains(issue("$MeshFormat\n4 0 8\n"), "version 4.000000 is not read (2.2 and 4.1 are)");
  expect_contains(issue("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"), "$Nodes: is missing");
  expect_contains(issue(""), "not an MSH file");
}

TEST_F(Gmsh, DamageIsRefusedOrHarmless) {
  MeshContents c = full_contents();
  c.fields.fields.resize(1);
  c.fields.fields[0].name = "h";
  for (const WriteOptions& options : kVariants) {
    write_gmsh(directory / "m.msh", c, options);
    const std::string bytes = bytes_of(directory / "m.msh");
    damage_everywhere(directory / "m.msh", bytes, read_gmsh);
    const std::size_t field = bytes.find("$NodeData");
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      put_bytes(directory / "m.msh", bytes.substr(0, length));
      const std::string message = message_of([&] { read_gmsh(directory / "m.msh"); });
      // A file may end before or behind the node data.
      const bool whole = length == field || length + 1 == field || length + 1 == bytes.size();
      EXPECT_EQ(message == "no error", whole) << length << ": " << message;
    }
  }
}

TEST_F(Gmsh, FilesOfGmsh) {
  for (const char* name :
       {"gmsh-box-41.msh", "gmsh-box-41-binary.msh", "gmsh-box-22.msh", "gmsh-box-22-binary.msh"}) {
    const MeshContents c = read_gmsh(sample(name));
    EXPECT_EQ(c.mesh.points.size(), 14u) << name;
    EXPECT_EQ(c.mesh.tets.size(), 24u);
    EXPECT_NEAR(total_volume(c.mesh), 1, 1e-14);
    EXPECT_EQ(c.mesh.tet_refs, std::vector<std::int32_t>(24, 30));
    EXPECT_EQ(std::ranges::count(c.mesh.triangle_refs, 10), 4);
    EXPECT_EQ(std::ranges::count(c.mesh.triangle_refs, 20), 20);
    EXPECT_EQ(c.mesh.edge_refs, std::vector<std::int32_t>(c.mesh.edges.size(), 40));
    EXPECT_EQ(c.mesh.corners, (std::vector<std::uint32_t>{0}));
    EXPECT_EQ(c.mesh.point_refs[0], 50);
    EXPECT_EQ(c.names.name(2, 20), "other sides");
    EXPECT_EQ(c.names.name(3, 30), "inside");
    EXPECT_EQ(c.names.name(1, 40), "front");
  }
}

TEST_F(Gmsh, PartitionedFilesOfGmsh) {
  const MeshContents c = read_gmsh(sample("gmsh-parts-41-binary.msh"));  // two cubes in two partitions
  EXPECT_EQ(std::ranges::count(c.mesh.tet_refs, 10), 24);
  EXPECT_EQ(std::ranges::count(c.mesh.tet_refs, 20), 24);
  EXPECT_NEAR(total_volume(c.mesh), 2, 1e-14);
  EXPECT_EQ(std::ranges::count(c.mesh.triangle_refs, 3), 20);
  EXPECT_EQ(std::ranges::count(c.mesh.triangle_refs, 7), 20);
  EXPECT_EQ(c.mesh.triangles.size(), 40u);
  EXPECT_EQ(c.mesh.edge_refs, (std::vector<std::int32_t>{6}));
  EXPECT_EQ(c.mesh.corners.size(), 1u);
}

TEST_F(Gmsh, PartitionedFilesAreNotReadInRanges) {
  const fs::path path = directory / "m.msh";
  write_gmsh(path, full_contents());
  EXPECT_TRUE(gmsh_size(path));
  std::string bytes = bytes_of(path);
  bytes.insert(bytes.find("$Nodes"),
               "$PartitionedEntities\n" + std::string(6 * 8, '\0') + "\n$EndPartitionedEntities\n");
  put_bytes(path, bytes);
  EXPECT_FALSE(gmsh_size(path));
  EXPECT_TRUE(read_gmsh(path).dropped.empty());
}

}  // namespace
}  // namespace weft::meshing::gmsh_test
