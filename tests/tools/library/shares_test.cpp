// After a mesh is read in shares no rank has more than its own, and together they are the whole.
#include "tools/library/jobs/sources/shares.h"

#include <gtest/gtest.h>

#include <array>
#include <exception>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "meshing/io/mesh_file.h"
#include "meshing/mesh/structured_box.h"
#include "tests/meshing/io/format_support.h"
#include "tests/partition/communication/threads_peers.h"

namespace weft::tools::shares_test {
namespace {

using meshing::MeshContents;
using meshing::MeshData;
using partition::MeshSlice;
using partition::Peers;

MeshContents marked_box() {
  MeshContents box;
  box.mesh = meshing::structured_box({{6, 5, 4}, {0, 0, 0}, {6, 5, 4}});
  for (std::uint32_t t = 0; t < box.mesh.triangles.size(); t += 2) box.mesh.required_triangles.push_back(t);
  for (std::uint32_t e = 0; e < box.mesh.edges.size(); e += 3) box.mesh.required_edges.push_back(e);
  box.mesh.ridges.clear();
  for (std::uint32_t e = 0; e < box.mesh.edges.size(); ++e) box.mesh.ridges.push_back(e);
  box.mesh.required_points = {3, 11};
  box.complete();
  return box;
}

template <class T>
void expect_joined(const std::vector<std::vector<T>>& shares, const std::vector<T>& whole) {
  std::vector<T> joined;
  for (const auto& share : shares) joined.insert(joined.end(), share.begin(), share.end());
  EXPECT_EQ(joined, whole);
}

template <class T>
void expect_shares(const std::vector<std::vector<T>>& shares, const std::vector<T>& whole) {
  for (const auto& share : shares) EXPECT_LE(share.size(), whole.size() / shares.size() + 1);
  expect_joined(shares, whole);
}

struct Shares {
  explicit Shares(std::size_t ranks)
      : triangles(ranks),
        edges(ranks),
        refs(ranks),
        ridges(ranks),
        edge_marks(ranks),
        triangle_marks(ranks),
        corners(ranks),
        point_marks(ranks) {}
  std::vector<std::vector<std::array<std::uint32_t, 3>>> triangles;
  std::vector<std::vector<std::array<std::uint32_t, 2>>> edges;
  std::vector<std::vector<std::int32_t>> refs;
  std::vector<std::vector<std::uint32_t>> ridges, edge_marks, triangle_marks, corners, point_marks;

  void take(std::size_t r, const MeshData& b) {
    triangles[r] = b.triangles, edges[r] = b.edges, refs[r] = b.triangle_refs;
    corners[r] = b.corners, point_marks[r] = b.required_points;
    ridges[r] = b.ridges, edge_marks[r] = b.required_edges, triangle_marks[r] = b.required_triangles;
  }
};

class MeshShares : public testing::TestWithParam<std::string> {
 protected:
  meshing::TemporaryDirectory directory;
};

TEST_P(MeshShares, OfTheBoundaryAreEven) {
  constexpr int kRanks = 4;
  const auto file = directory / GetParam();
  meshing::write_mesh_contents(file, marked_box());
  const MeshData whole = meshing::read_mesh(file);
  Shares shares(kRanks);
  support::run_ranks(kRanks, [&](Peers& peers) {
    const MeshSlice slice = read_mesh_share(peers, file.string()).slice;
    const auto r = static_cast<std::size_t>(peers.rank());
    EXPECT_EQ(slice.num_triangles, whole.triangles.size());
    EXPECT_EQ(slice.num_edges, whole.edges.size());
    EXPECT_EQ(slice.first_triangle, whole.triangles.size() * r / kRanks);
    EXPECT_EQ(slice.first_edge, whole.edges.size() * r / kRanks);
    shares.take(r, slice.boundary);
  });
  expect_shares(shares.triangles, whole.triangles);
  expect_shares(shares.refs, whole.triangle_refs);
  expect_shares(shares.edges, whole.edges);
  expect_shares(shares.ridges, whole.ridges);
  expect_shares(shares.edge_marks, whole.required_edges);
  expect_shares(shares.triangle_marks, whole.required_triangles);
  expect_joined(shares.corners, whole.corners);
  expect_joined(shares.point_marks, whole.required_points);
  for (const auto& share : shares.corners)
    EXPECT_TRUE(whole.corners.empty() || share.size() < whole.corners.size());
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshShares,
                         testing::Values("m.meshb", "m.mesh", "m.lb8.ugrid", "m.ugrid", "m.cgns", "m.vtu",
                                         "m.msh", "m.su2", "m.pvtu"));

TEST(MeshShare, OfCgnsWithMixedElementsIsReadByEachRank) {
  constexpr int kRanks = 4;
  const std::string file = meshing::sample("cgns-mixed.cgns").string();
  meshing::RefNames names;
  const MeshData whole = meshing::read_mesh(file, &names);
  std::vector<std::vector<meshing::Point>> points(kRanks);
  std::vector<std::vector<std::array<std::uint32_t, 4>>> tets(kRanks);
  std::vector<std::vector<std::int32_t>> tet_refs(kRanks);
  Shares shares(kRanks);
  support::run_ranks(kRanks, [&](Peers& peers) {
    const MeshShare share = read_mesh_share(peers, file);
    const auto r = static_cast<std::size_t>(peers.rank());
    EXPECT_FALSE(share.read_whole);
    EXPECT_EQ(share.names.all(), names.all());
    points[r] = share.slice.points, tets[r] = share.slice.tets, tet_refs[r] = share.slice.tet_refs;
    shares.take(r, share.slice.boundary);
  });
  expect_shares(points, whole.points);
  expect_shares(tets, whole.tets);
  expect_shares(tet_refs, whole.tet_refs);
  expect_shares(shares.triangles, whole.triangles);
  expect_shares(shares.refs, whole.triangle_refs);
  expect_shares(shares.edges, whole.edges);
}

struct FieldFile {
  const char* name;
  meshing::WriteOptions options = {};

  friend void PrintTo(const FieldFile& file, std::ostream* out) {
    *out << file.name << (file.options.encoding == meshing::WriteOptions::Encoding::ascii ? " text" : "")
         << " version " << file.options.gmsh_version;
  }
};

std::string no_length(std::uint64_t) { return "is of another mesh"; }

class FieldShares : public testing::TestWithParam<FieldFile> {
 protected:
  /// The values of all ranks joined are those of one reader.
  static void expect_fields(const std::string& file, int ranks) {
    SCOPED_TRACE(ranks);
    const Fields whole = meshing::read_mesh_contents(file).fields;
    std::vector<Fields> shares(static_cast<std::size_t>(ranks));
    support::run_ranks(ranks, [&](Peers& peers) {
      const MeshSlice slice = read_mesh_share(peers, file).slice;
      const Fields mine = read_fields_share(peers, file, slice, no_length);
      EXPECT_EQ(mine.num_points, slice.points.size());
      shares[static_cast<std::size_t>(peers.rank())] = mine;
    });
    for (std::size_t f = 0; f < whole.fields.size(); ++f) {
      std::vector<std::vector<double>> values;
      for (const Fields& share : shares) {
        ASSERT_EQ(share.fields.size(), whole.fields.size());
        EXPECT_EQ(share.fields[f].kind, whole.fields[f].kind);
        EXPECT_EQ(share.fields[f].name, whole.fields[f].name);
        values.push_back(share.fields[f].values);
      }
      expect_joined(values, whole.fields[f].values);
    }
  }

  meshing::TemporaryDirectory directory;
};

TEST_P(FieldShares, AreTheWhole) {
  MeshContents box = marked_box();
  const std::size_t n = box.mesh.points.size();
  box.fields.num_points = n;
  for (const auto kind : {Field::Kind::scalar, Field::Kind::tensor, Field::Kind::vector}) {
    Field& field = box.fields.fields.emplace_back(kind, std::vector<double>(),
                                                  "field " + std::to_string(box.fields.fields.size()));
    for (std::size_t i = 0; i < n * static_cast<std::size_t>(meshing::components(kind)); ++i)
      field.values.push_back(1.0 / static_cast<double>(i + 3));
  }
  const std::string file = (directory / GetParam().name).string();
  meshing::write_mesh_contents(file, box, GetParam().options);
  EXPECT_TRUE(fields_in_shares(file));
  for (const int ranks : {1, 2, 3, 5}) expect_fields(file, ranks);
}

constexpr auto kAscii = meshing::WriteOptions::Encoding::ascii;
INSTANTIATE_TEST_SUITE_P(Formats, FieldShares,
                         testing::Values(FieldFile{"m.vtu"}, FieldFile{"m.cgns"}, FieldFile{"m.msh"},
                                         FieldFile{"m.msh", {.encoding = kAscii}},
                                         FieldFile{"m.msh", {.gmsh_version = 2}},
                                         FieldFile{"m.msh", {.encoding = kAscii, .gmsh_version = 2}}));

std::vector<std::string> texts_of(const std::vector<Dropped>& dropped) {
  std::vector<std::string> texts;
  for (const Dropped& d : dropped) texts.push_back(std::to_string(d.count) + " " + d.what);
  return texts;
}

/// Five nodes whose tags have gaps and no order, two tets, and node data.
std::string gmsh_text(const std::string& node_data) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n70 0 0 0\n3 1 0 0\n900 0 1 0\n5 0 0 1\n8 1 1 1\n"
         "$EndNodes\n$Elements\n2\n1 4 2 1 1 70 3 900 5\n2 4 2 1 1 3 900 5 8\n$EndElements\n" +
         node_data;
}
std::string node_data(const std::string& name, int components, int count, const std::string& rows) {
  return "$NodeData\n1\n\"" + name + "\"\n1\n0\n3\n0\n" + std::to_string(components) + "\n" +
         std::to_string(count) + "\n" + rows + "$EndNodeData\n";
}

TEST_F(FieldShares, OfNodesInAnyOrderWithGapsAndTwice) {
  const auto file = directory / "m.msh";
  std::string skew;
  for (const char* tag : {"3", "5", "8", "70", "900"}) skew += std::string(tag) + " 1 2 3 4 5 6 7 8 9\n";
  meshing::put_bytes(
      file,
      gmsh_text(node_data("a", 1, 6, "900 1\n5 2\n70 3\n5 4\n8 5\n3 6\n") +
                node_data("gaps", 1, 5, "900 1\n5 2\n70 3\n5 4\n8 5\n") + node_data("skew", 9, 5, skew) +
                node_data("b", 3, 5, "8 1 2 3\n3 4 5 6\n70 7 8 9\n5 1 1 1\n900 2 2 2\n")));
  const MeshContents whole = meshing::read_mesh_contents(file);
  EXPECT_EQ(whole.fields.fields.size(), 2u);
  EXPECT_EQ(whole.fields.fields[0].values, (std::vector<double>{3, 6, 1, 4, 5}));
  for (const int ranks : {1, 2, 3, 4, 7}) {
    expect_fields(file.string(), ranks);
    support::run_ranks(ranks, [&](Peers& peers) {
      const FieldsShare share = read_own_fields_share(peers, file.string());
      EXPECT_EQ(share.num_points, 5u);
      EXPECT_EQ(texts_of(share.dropped), texts_of(whole.dropped));
    });
  }
}

/// Sections that ranges of the mesh do not see, and fields of several blocks.
TEST_F(FieldShares, TellWhatElseIsInTheFile) {
  MeshContents box;
  box.mesh = meshing::structured_box({{40, 40, 40}, {0, 0, 0}, {1, 1, 1}});
  box.complete();
  const std::size_t n = box.mesh.points.size();
  ASSERT_GT(n, meshing::FieldStream::kRows);
  box.fields = {n, {{Field::Kind::scalar, std::vector<double>(n), "a"}}};
  for (std::size_t i = 0; i < n; ++i) box.fields.fields[0].values[i] = 1.0 / static_cast<double>(i + 1);
  const auto file = directory / "m.msh";
  meshing::write_mesh_contents(file, box);
  meshing::put_bytes(file,
                     meshing::bytes_of(file) + "$Foo\n1\n$EndFoo\n$Foo\n$EndFoo\n$Comments\n$EndComments\n");
  const MeshContents whole = meshing::read_mesh_contents(file);
  EXPECT_EQ(texts_of(whole.dropped), std::vector<std::string>{"2 sections $Foo"});
  expect_fields(file.string(), 3);
  support::run_ranks(3, [&](Peers& peers) {
    EXPECT_TRUE(read_mesh_share(peers, file.string()).dropped.empty());
    EXPECT_EQ(texts_of(read_own_fields_share(peers, file.string()).dropped), texts_of(whole.dropped));
  });
}

TEST_F(FieldShares, ThatAreDamagedAreRefusedOnAllRanksInTheSameWords) {
  const auto file = directory / "m.msh";
  const std::string rows = "900 1\n5 2\n70 3\n4 4\n8 5\n3 6\n";
  for (const std::string& bytes :
       {gmsh_text(node_data("a", 1, 6, rows)), gmsh_text(node_data("a", 2, 6, rows)),
        gmsh_text(node_data("a", 1, 9000, rows)), gmsh_text("$NodeData\n1\n\"a\"\n1\n0\n3\n0\n1\n"),
        gmsh_text("")}) {
    meshing::put_bytes(file, bytes);
    const std::string expected = meshing::message_of([&] { meshing::read_solution(file); });
    EXPECT_NE(expected, "no error");
    for (const auto& exception : support::run_ranks_caught(3, [&](Peers& peers) {
           MeshSlice slice;
           slice.num_points = 5;
           read_fields_share(peers, file.string(), slice, no_length);
         }))
      EXPECT_EQ(meshing::message_of([&] {
                  if (exception) std::rethrow_exception(exception);
                }),
                expected);
  }
}

TEST_F(FieldShares, OfAnotherMeshAreRefused) {
  const auto file = directory / "m.msh";
  meshing::put_bytes(file, gmsh_text(node_data("a", 1, 5, "900 1\n5 2\n70 3\n8 5\n3 6\n")));
  for (const auto& exception : support::run_ranks_caught(2, [&](Peers& peers) {
         MeshSlice slice;
         slice.num_points = 6;
         read_fields_share(peers, file.string(), slice, no_length);
       }))
    meshing::expect_contains(meshing::message_of([&] {
                               if (exception) std::rethrow_exception(exception);
                             }),
                             "is of another mesh");
}

}  // namespace
}  // namespace weft::tools::shares_test
