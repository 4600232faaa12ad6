// Parts of GMF files: put together they are the whole, and every issue is that of the whole reader.
#include "meshing/io/gmf/gmf_slice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf.h"
#include "tests/meshing/io/format_support.h"
#include "tests/support/meshes.h"

namespace weft::meshing::gmf_slice_test {
namespace {

/// A mesh with all kinds of marks and references.
MeshData marked_cube(std::uint32_t n) {
  MeshData mesh = support::unit_cube(n);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) mesh.point_refs[i] = static_cast<std::int32_t>(i % 7);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) mesh.tet_refs[t] = -static_cast<std::int32_t>(t % 5);
  mesh.required_points = {3, 1};
  mesh.required_edges = {2};
  mesh.required_triangles = {0, 4};
  mesh.association.nodes = {{0, 1}, {4, 2}};
  mesh.association.edges = {{0, 1, 0.5, 1}, {1, 2, 0.25, 2}, {4, 3, -1, 3}};
  mesh.association.faces = {{2, 4, 0.5, 0.75, 4}};
  return mesh;
}

/// A field of each kind at every point.
SolutionData fields_at(std::size_t num_points) {
  SolutionData solution{num_points, {}};
  for (const auto kind : {Field::Kind::scalar, Field::Kind::tensor, Field::Kind::vector}) {
    Field field{kind, {}, {}};
    for (std::size_t i = 0; i < num_points * static_cast<std::size_t>(components(kind)); ++i)
      field.values.push_back(0.25 * static_cast<double>(i) - 3);
    solution.fields.push_back(field);
  }
  return solution;
}

/// The whole mesh put together of `parts` parts.
MeshData read_in_parts(const fs::path& path, std::uint64_t parts) {
  const GmfLayout layout = read_gmf_layout(path);
  MeshData mesh;
  const auto append = [](auto& all, const auto& part) { all.insert(all.end(), part.begin(), part.end()); };
  for (std::uint64_t p = 0; p < parts; ++p) {
    MeshRange range;
    range.part = p, range.parts = parts;
    const MeshData boundary = read_gmf_boundary(path, layout, range);
    EXPECT_LE(boundary.triangles.size(), layout.num_triangles() / parts + 1);
    append(mesh.triangles, boundary.triangles), append(mesh.triangle_refs, boundary.triangle_refs);
    append(mesh.edges, boundary.edges), append(mesh.edge_refs, boundary.edge_refs);
    append(mesh.ridges, boundary.ridges);
    append(mesh.required_edges, boundary.required_edges);
    append(mesh.required_triangles, boundary.required_triangles);
    append(mesh.association.nodes, boundary.association.nodes);
    append(mesh.association.edges, boundary.association.edges);
    append(mesh.association.faces, boundary.association.faces);
    append(mesh.corners, boundary.corners);
    append(mesh.required_points, boundary.required_points);
    const auto begin = [&](std::uint64_t n, std::uint64_t part) { return n * part / parts; };
    const std::uint64_t v = begin(layout.num_points(), p), t = begin(layout.num_tets(), p);
    const GmfPoints points = read_gmf_points(path, layout, v, begin(layout.num_points(), p + 1) - v);
    const GmfTets tets = read_gmf_tets(path, layout, t, begin(layout.num_tets(), p + 1) - t);
    append(mesh.points, points.points), append(mesh.point_refs, points.refs);
    append(mesh.tets, tets.tets), append(mesh.tet_refs, tets.refs);
  }
  return mesh;
}

/// The bytes of a binary file of version 2 with all numbers of `sizes` bytes each reversed.
std::string reversed(std::string bytes, const std::vector<std::size_t>& sizes) {
  auto at = bytes.begin();
  for (const std::size_t size : sizes) {
    std::reverse(at, at + static_cast<std::ptrdiff_t>(size));
    at += static_cast<std::ptrdiff_t>(size);
  }
  EXPECT_EQ(at, bytes.end());
  return bytes;
}

class GmfSlice : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Versions, GmfSlice, testing::Values(1, 2, 3, 4));

TEST_P(GmfSlice, PartsOfAMeshAreTheWhole) {
  const TemporaryDirectory directory;
  for (const std::string name : {"m.meshb", "m.mesh"}) {
    write_gmf_mesh(directory / name, marked_cube(4), GetParam());
    const MeshData whole = read_gmf_mesh(directory / name);
    for (const std::uint64_t parts : {1, 2, 3, 7, 500}) {
      expect_equal(read_in_parts(directory / name, parts), whole);
    }
  }
}

TEST_P(GmfSlice, RandomRangesOfASolutionAreThoseOfTheWhole) {
  const TemporaryDirectory directory;
  std::mt19937 random(3);
  for (const std::string name : {"s.solb", "s.sol"}) {
    write_gmf_solution(directory / name, fields_at(60), GetParam());
    const SolutionData whole = read_gmf_solution(directory / name);
    const GmfLayout layout = read_gmf_layout(directory / name);
    ASSERT_EQ(layout.num_solution_points(), 60u);
    for (int trial = 0; trial < 20; ++trial) {
      const std::uint64_t first = random() % 61, count = random() % (61 - first);
      const SolutionData part = read_gmf_solution_slice(directory / name, layout, first, count);
      ASSERT_EQ(part.num_points, count);
      ASSERT_EQ(part.fields.size(), whole.fields.size());
      for (std::size_t f = 0; f < whole.fields.size(); ++f) {
        const auto length = static_cast<std::size_t>(components(whole.fields[f].kind));
        const auto begin = whole.fields[f].values.begin() + static_cast<std::ptrdiff_t>(first * length);
        EXPECT_EQ(part.fields[f].values,
                  std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(count * length)));
      }
    }
  }
}

TEST(GmfSlices, ReadTheOtherByteOrder) {
  const TemporaryDirectory directory;
  MeshData mesh = support::two_tets();
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  write_gmf_mesh(directory / "m.meshb", mesh, 2);
  std::vector<std::size_t> sizes = {4, 4, 4, 4, 4, 4, 4, 4};  // header, Dimension, head of the Vertices
  for (int v = 0; v < 5; ++v) sizes.insert(sizes.end(), {8, 8, 8, 4});
  sizes.insert(sizes.end(), 3 + 2 * 5 + 2, 4);
  put_bytes(directory / "m.meshb", reversed(bytes_of(directory / "m.meshb"), sizes));
  expect_equal(read_in_parts(directory / "m.meshb", 2), mesh);
}

TEST(GmfSlices, LargeFilesPassTheBuffers) {
  const TemporaryDirectory directory;
  MeshData mesh;
  for (int i = 0; i < 150000; ++i) {
    mesh.points.push_back({1.0 * i, 1.0 / (i + 1), -1.0 * i});
    mesh.point_refs.push_back(i);
  }
  write_gmf_mesh(directory / "m.meshb", mesh);
  for (const std::uint64_t parts : {1, 2, 5}) expect_equal(read_in_parts(directory / "m.meshb", parts), mesh);
}

TEST(GmfSlices, RowsThatAreNotThereAreNotRead) {
  const TemporaryDirectory directory;
  for (const std::string name : {"m.meshb", "m.mesh"}) {
    write_gmf_mesh(directory / name, two_tets());
    const GmfLayout layout = read_gmf_layout(directory / name);
    EXPECT_THROW(read_gmf_points(directory / name, layout, 5, 1), std::out_of_range);
    EXPECT_THROW(read_gmf_points(directory / name, layout, 0, 6), std::out_of_range);
    EXPECT_THROW(read_gmf_tets(directory / name, layout, ~std::uint64_t{0}, 2), std::out_of_range);
    EXPECT_EQ(read_gmf_points(directory / name, layout, 5, 0).points.size(), 0u);
  }
}

TEST(GmfSlices, AFileThatChangedIsRefused) {
  const TemporaryDirectory directory;
  for (const std::string name : {"m.meshb", "m.mesh"}) {
    write_gmf_mesh(directory / name, two_tets());
    const GmfLayout layout = read_gmf_layout(directory / name);
    write_gmf_mesh(directory / name, support::regular_tet());
    expect_contains(message_of([&] { read_gmf_points(directory / name, layout, 0, 1); }),
                    name + ": the file was changed while it was read");
  }
}

/// What a reader throws as InputError, empty for nothing.
template <class Read>
std::string issue(const Read& read) {
  try {
    read();
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

/// Damages every byte of a file: the parts must fail exactly when the whole does. The words are the same
/// but for files with several faults, of which another may come first.
void damage_bytes(const fs::path& path) {
  const std::string bytes = bytes_of(path);
  std::size_t issues = 0, alike = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int change : {1, 0x80, 0xFF}) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ change);
      put_bytes(path, damaged);
      const std::string whole = issue([&] { read_gmf_mesh(path); });
      const std::string parts = issue([&] { read_in_parts(path, 2); });
      EXPECT_EQ(whole.empty(), parts.empty()) << "byte " << at << ": " << whole << " / " << parts;
      issues += !whole.empty();
      alike += !whole.empty() && whole == parts;
    }
  }
  EXPECT_GT(issues, bytes.size());
  EXPECT_GT(alike, issues * 9 / 10);
}

TEST_P(GmfSlice, DamageIsFoundAsInTheWhole) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.meshb", two_tets(), GetParam());
  damage_bytes(directory / "m.meshb");
}

TEST(GmfSlices, DamagedTextIsFoundAsInTheWhole) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.mesh", two_tets());
  damage_bytes(directory / "m.mesh");
}

TEST_P(GmfSlice, EveryTruncationIsRefused) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.meshb", two_tets(), GetParam());
  const std::string bytes = bytes_of(directory / "m.meshb");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    if (length + (GetParam() >= 3 ? 8 : 4) == bytes.size()) continue;  // the End needs no position
    put_bytes(directory / "m.meshb", bytes.substr(0, length));
    EXPECT_THROW(read_gmf_layout(directory / "m.meshb"), InputError) << "length " << length;
  }
}

TEST(GmfSlices, ErrorsNumberRowsInTheWholeFile) {
  const TemporaryDirectory directory;
  MeshData mesh = support::unit_cube(2);
  write_gmf_mesh(directory / "m.meshb", mesh, 2);
  std::string bytes = bytes_of(directory / "m.meshb");
  const std::size_t vertices = 8 + 12 + 12;  // header, Dimension, head of the Vertices
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::memcpy(bytes.data() + vertices + 20 * 28 + 16, &nan, sizeof nan);
  put_bytes(directory / "m.meshb", bytes);
  const GmfLayout layout = read_gmf_layout(directory / "m.meshb");
  EXPECT_NO_THROW(read_gmf_points(directory / "m.meshb", layout, 0, 20));
  EXPECT_NO_THROW(read_gmf_points(directory / "m.meshb", layout, 21, 6));
  expect_contains(message_of([&] { read_gmf_points(directory / "m.meshb", layout, 18, 5); }),
                  "m.meshb: Vertices 21: a coordinate is not finite");
}

TEST(GmfSlices, MissingAndForeignSectionsAreNamed) {
  const TemporaryDirectory directory;
  const auto put = [&](const std::string& sections) {
    put_bytes(directory / "m.mesh", "MeshVersionFormatted 2\nDimension 3\n" + sections + "\nEnd\n");
    return read_gmf_layout(directory / "m.mesh");
  };
  expect_contains(message_of([&] { put("Vertices 0\nPyramids 1\n1 1 1 1 1 0"); }),
                  "Pyramids: the mesh has 1");
  const GmfLayout empty = put("");
  expect_contains(message_of([&] { read_gmf_points(directory / "m.mesh", empty, 0, 0); }),
                  "Vertices: are missing");
  expect_contains(message_of([&] { read_gmf_solution_slice(directory / "m.mesh", empty, 0, 0); }),
                  "SolAtVertices: is missing");
  EXPECT_EQ(read_gmf_tets(directory / "m.mesh", empty, 0, 0).tets.size(), 0u);
}

}  // namespace
}  // namespace weft::meshing::gmf_slice_test
