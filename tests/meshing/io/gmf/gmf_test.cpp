// GMF files: round trips in every version, byte order and as text; damaged files; failing output.
#include "meshing/io/gmf/gmf.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "tests/meshing/io/format_support.h"

namespace weft::meshing::gmf_test {
namespace {

/// One field of each kind at four points, again exact in 32 bits.
SolutionData three_fields() {
  SolutionData s;
  s.num_points = 4;
  for (const auto kind : {Field::Kind::scalar, Field::Kind::vector, Field::Kind::tensor}) {
    Field field{kind, {}, {}};
    for (int i = 0; i < 4 * components(kind); ++i) field.values.push_back(0.25 * i - 1);
    s.fields.push_back(field);
  }
  return s;
}

template <class T>
T value_at(const std::string& bytes, std::size_t position) {
  T value;
  std::memcpy(&value, bytes.data() + position, sizeof value);
  return value;
}
template <class T>
std::string with_value(std::string bytes, std::size_t position, T value) {
  std::memcpy(bytes.data() + position, &value, sizeof value);
  return bytes;
}
template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The layout of one binary GMF file, found independently of the reader.
struct Layout {
  explicit Layout(const std::string& bytes) : version(value_at<std::int32_t>(bytes, 4)) {}
  std::int32_t version;
  std::size_t real() const { return version == 1 ? 4 : 8; }
  std::size_t index() const { return version == 4 ? 8 : 4; }
  std::size_t pointer() const { return version >= 3 ? 8 : 4; }
  std::size_t next(const std::string& bytes, std::size_t at) const {
    return pointer() == 8 ? value_at<std::uint64_t>(bytes, at + 4) : value_at<std::uint32_t>(bytes, at + 4);
  }
};

/// Where keyword `code` begins in a binary file of this machine's byte order.
std::size_t find_keyword(const std::string& bytes, std::int32_t code) {
  const Layout layout(bytes);
  std::size_t at = 8;
  while (value_at<std::int32_t>(bytes, at) != code) at = layout.next(bytes, at);
  return at;
}

/// Reverses numbers of a binary file one after another.
class ByteSwapper {
 public:
  explicit ByteSwapper(std::string bytes) : bytes_(std::move(bytes)) {}
  void swap(std::size_t size, std::size_t count = 1) {
    for (; count > 0; --count, at_ += size) {
      const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
      std::reverse(begin, begin + static_cast<std::ptrdiff_t>(size));
    }
  }
  std::size_t at() const { return at_; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

std::string byte_swapped(const std::string& bytes) {
  const Layout layout(bytes);
  ByteSwapper out(bytes);
  out.swap(4, 2);
  for (;;) {
    const auto code = value_at<std::int32_t>(bytes, out.at());
    const std::size_t next = layout.next(bytes, out.at());
    out.swap(4);
    out.swap(layout.pointer());
    if (code == 54) return out.bytes();
    if (code == 3) {
      out.swap(4);
      continue;
    }
    out.swap(layout.index());
    if (code == 62) out.swap(4, 1 + static_cast<std::size_t>(value_at<std::int32_t>(bytes, out.at())));
    while (out.at() < next) {
      if (code == 4) out.swap(layout.real(), 3);
      code == 62 ? out.swap(layout.real()) : out.swap(layout.index());
    }
  }
}

/// The reader's issue about a mesh file with these bytes.
std::string issue(const TemporaryDirectory& directory, const std::string& name, const std::string& bytes) {
  put_bytes(directory / name, bytes);
  return message_of([&] { read_gmf_mesh(directory / name); });
}

class GmfVersion : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(All, GmfVersion, testing::Values(1, 2, 3, 4));

TEST_P(GmfVersion, MeshSurvivesBinaryRoundTrip) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.meshb", two_tets(), GetParam());
  EXPECT_EQ(value_at<std::int32_t>(bytes_of(directory / "m.meshb"), 4), GetParam());
  expect_equal(read_gmf_mesh(directory / "m.meshb"), two_tets());
}

TEST_P(GmfVersion, SolutionSurvivesBinaryRoundTrip) {
  const TemporaryDirectory directory;
  write_gmf_solution(directory / "s.solb", three_fields(), GetParam());
  expect_equal(read_gmf_solution(directory / "s.solb"), three_fields());
}

TEST_P(GmfVersion, ReadsTheOtherByteOrder) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.meshb", two_tets(), GetParam());
  put_bytes(directory / "m.meshb", byte_swapped(bytes_of(directory / "m.meshb")));
  expect_equal(read_gmf_mesh(directory / "m.meshb"), two_tets());

  write_gmf_solution(directory / "s.solb", three_fields(), GetParam());
  put_bytes(directory / "s.solb", byte_swapped(bytes_of(directory / "s.solb")));
  expect_equal(read_gmf_solution(directory / "s.solb"), three_fields());
}

TEST_P(GmfVersion, SurvivesTextRoundTrip) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.mesh", two_tets(), GetParam());
  expect_equal(read_gmf_mesh(directory / "m.mesh"), two_tets());
  write_gmf_solution(directory / "s.sol", three_fields(), GetParam());
  expect_equal(read_gmf_solution(directory / "s.sol"), three_fields());
}

/// How long the file is without the position behind its End, as Mmg writes solutions.
std::size_t without_position(const std::string& bytes) { return bytes.size() - Layout(bytes).pointer(); }

TEST_P(GmfVersion, TheEndMayHaveNoPosition) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.meshb", two_tets(), GetParam());
  const std::string bytes = bytes_of(directory / "m.meshb"), cut = bytes.substr(0, without_position(bytes));
  for (const std::string& file : {cut, byte_swapped(bytes).substr(0, cut.size())}) {
    put_bytes(directory / "m.meshb", file);
    expect_equal(read_gmf_mesh(directory / "m.meshb"), two_tets());
  }
  write_gmf_solution(directory / "s.solb", three_fields(), GetParam());
  const std::string solution = bytes_of(directory / "s.solb");
  put_bytes(directory / "s.solb", solution.substr(0, without_position(solution)));
  expect_equal(read_gmf_solution(directory / "s.solb"), three_fields());
}

TEST_P(GmfVersion, EveryTruncationIsRefused) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.meshb", two_tets(), GetParam());
  write_gmf_solution(directory / "s.solb", three_fields(), GetParam());
  const std::string mesh = bytes_of(directory / "m.meshb"), solution = bytes_of(directory / "s.solb");
  for (std::size_t length = 0; length < mesh.size(); ++length) {
    if (length == without_position(mesh)) continue;
    put_bytes(directory / "m.meshb", mesh.substr(0, length));
    EXPECT_THROW(read_gmf_mesh(directory / "m.meshb"), InputError) << "length " << length;
  }
  for (std::size_t length = 0; length < solution.size(); ++length) {
    if (length == without_position(solution)) continue;
    put_bytes(directory / "s.solb", solution.substr(0, length));
    EXPECT_THROW(read_gmf_solution(directory / "s.solb"), InputError) << "length " << length;
  }
}

void read_and_check_mesh(const fs::path& path) { expect_in_range(read_gmf_mesh(path)); }
void read_and_check_solution(const fs::path& path) {
  const SolutionData s = read_gmf_solution(path);
  for (const Field& field : s.fields) {
    EXPECT_EQ(field.values.size(), s.num_points * static_cast<std::size_t>(components(field.kind)));
  }
}

TEST_P(GmfVersion, EveryChangedByteIsRefusedOrHarmless) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.meshb", two_tets(), GetParam());
  change_every_byte(directory / "m.meshb", bytes_of(directory / "m.meshb"), read_and_check_mesh);
  write_gmf_solution(directory / "s.solb", three_fields(), GetParam());
  change_every_byte(directory / "s.solb", bytes_of(directory / "s.solb"), read_and_check_solution);
}

TEST(GmfText, EveryChangedByteIsRefusedOrHarmless) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.mesh", two_tets());
  change_every_byte(directory / "m.mesh", bytes_of(directory / "m.mesh"), read_and_check_mesh);
  write_gmf_solution(directory / "s.sol", three_fields());
  change_every_byte(directory / "s.sol", bytes_of(directory / "s.sol"), read_and_check_solution);
}

TEST(GmfText, EveryTruncationIsRefused) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.mesh", two_tets());
  const std::string bytes = bytes_of(directory / "m.mesh");
  for (std::size_t length = 0; length + 1 < bytes.size(); ++length) {  // only the last line feed is optional
    put_bytes(directory / "m.mesh", bytes.substr(0, length));
    EXPECT_THROW(read_gmf_mesh(directory / "m.mesh"), InputError) << "length " << length;
  }
}

TEST(GmfText, KeepsEveryDigit) {
  const TemporaryDirectory directory;
  MeshData mesh = two_tets();
  mesh.points[0] = {1.0 / 3, -1e-300, 123456789.123456789};
  mesh.points[1] = {std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max(), 0.1 + 0.2};
  write_gmf_mesh(directory / "m.mesh", mesh);
  EXPECT_EQ(read_gmf_mesh(directory / "m.mesh").points, mesh.points);
}

TEST(GmfText, ReadsFreeFormAndSkipsWhatItDoesNotKeep) {
  const TemporaryDirectory directory;
  put_bytes(directory / "m.mesh",
            "# made by hand\r\nMeshVersionFormatted\r\n1\r\nDimension\n3 # three\n"
            "Vertices 4\n0 0 0 1  +1 0 0 1\n 0 1.0D+00 0 1 0 0 1e-999 1\n"
            "Normals\n2\n0 0 1\n0 nan 1\nNormalAtVertices\n1\n1 1\nTangents\n0\nMyOwnSection 3 1 2 3\n"
            "Hexahedra 0\nTetrahedra\n1\n1 2 3 4 9\nEnd");
  const MeshData mesh = read_gmf_mesh(directory / "m.mesh");
  EXPECT_EQ(mesh.points, (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}}));
  EXPECT_EQ(mesh.tet_refs, std::vector<std::int32_t>{9});
}

TEST(GmfText, ErrorsNameTheEntity) {
  const TemporaryDirectory directory;
  const auto about = [&](const std::string& sections) {
    return issue(directory, "m.mesh", "MeshVersionFormatted 2\nDimension 3\n" + sections + "\nEnd\n");
  };
  const std::string vertices = "Vertices 2\n0 0 0 0\n1 1 1 0\n";
  expect_contains(about("Vertices 2\n0 0 0 0\n1 x 1 0"), "m.mesh: Vertices 2: expected a number, found 'x'");
  expect_contains(about("Vertices 2\n0 0 0 0\n1 1 nan 0"), "Vertices 2: a coordinate is not finite");
  expect_contains(about("Vertices 2\n0 0 0 0\n1 1 1e999 0"), "Vertices 2: a coordinate is not finite");
  expect_contains(about("Vertices 2\n0 0 0 0\n1 1 1 0\n2 2 2 0"),
                  "more values than its count of 2 rows needs");
  expect_contains(about("Vertices 3\n0 0 0 0\n1 1 1 0\nTetrahedra 0"),
                  "Vertices 3: expected a number, found 'Tetrahedra'");
  expect_contains(about("Vertices 999999999\n0 0 0 0\n"), "999999999 rows are more than the file can hold");
  expect_contains(about("Vertices many\n"), "expected a count, found 'many'");
  expect_contains(about(vertices + "Edges 1\n1 3 0"), "Edges 1: vertex index 3 is out of range 1..2");
  expect_contains(about(vertices + "Edges 1\n1 1.5 0"), "Edges 1: expected an integer, found '1.5'");
  expect_contains(about(vertices + "Edges 1\n1 2 3000000000"), "reference 3000000000 does not fit 32 bits");
  expect_contains(about(vertices + "Ridges 1\n1"), "Ridges 1: edge index 1, but the file has none");
  expect_contains(about(vertices + vertices), "Vertices: appears twice");
  expect_contains(about(vertices + "Pyramids 1\n1 1 1 1 1 0"), "Pyramids: the mesh has 1 of them");
  expect_contains(about("Tetrahedra 0"), "Vertices: are missing");
  expect_contains(issue(directory, "m.mesh", "MeshVersionFormatted 2\nDimension 2\nEnd"), "two-dimensional");
  expect_contains(issue(directory, "m.mesh", "MeshVersionFormatted 9\nDimension 3\nEnd"), "version 9");
  expect_contains(issue(directory, "m.mesh", "MeshVersionFormatted 2\nEnd"), "Dimension: is missing");
  expect_contains(issue(directory, "m.mesh", "solid cube"), "not an ASCII GMF file");
}

class GmfBinary : public testing::Test {
 protected:
  void SetUp() override {
    write_gmf_mesh(directory / "m.meshb", two_tets(), 2);
    bytes = bytes_of(directory / "m.meshb");
  }
  std::string about(const std::string& damaged) { return issue(directory, "m.meshb", damaged); }

  /// Position of row `row` of a section of 4-byte integers, or of the Vertices in version 2.
  std::size_t row(std::int32_t code, std::size_t index, std::size_t row_size) {
    return find_keyword(bytes, code) + 12 + index * row_size;
  }
  /// The file with a section put before the End.
  std::string with_section(std::int32_t code, std::int32_t count, const std::string& data) {
    const std::size_t at = bytes.size() - 8;
    std::string out = bytes.substr(0, at);
    append(out, code);
    append(out, static_cast<std::int32_t>(at + 12 + data.size()));
    append(out, count);
    return out + data + bytes.substr(at);
  }

  TemporaryDirectory directory;
  std::string bytes;
};

TEST_F(GmfBinary, ErrorsNameTheEntity) {
  expect_contains(about(with_value(bytes, row(8, 1, 20) + 8, 99999)),
                  "m.meshb: Tetrahedra 2: vertex index 99999 is out of range 1..5");
  expect_contains(about(with_value(bytes, row(8, 0, 20), 0)), "Tetrahedra 1: vertex index 0 is out of range");
  expect_contains(about(with_value(bytes, row(17, 0, 4), 4)), "RequiredTriangles 1: triangle index 4");
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  expect_contains(about(with_value(bytes, row(4, 2, 28) + 8, nan)), "Vertices 3: a coordinate is not finite");
  expect_contains(about(with_value(bytes, row(4, 4, 28), -inf)), "Vertices 5: a coordinate is not finite");
  expect_contains(about(with_value(bytes, 16, 2)), "two-dimensional");
  expect_contains(about(with_value(bytes, 4, 5)), "GMF version 5 is unknown");
  expect_contains(about(with_value(bytes, 0, 2)), "not a binary GMF file");
  expect_contains(about("MeshVersionFormatted 2"), "not a binary GMF file");
  expect_contains(about(""), "too short");
}

TEST_F(GmfBinary, WrongCountsAllocateNothing) {
  const std::size_t count = find_keyword(bytes, 8) + 8;
  expect_contains(about(with_value(bytes, count, 0x7FFFFFFF)),
                  "Tetrahedra: 2147483647 rows of 20 bytes do not fill");
  expect_contains(about(with_value(bytes, count, -1)), "Tetrahedra: its count is negative");
  expect_contains(about(with_value(bytes, count, 1)), "Tetrahedra: 1 rows of 20 bytes do not fill");
  write_gmf_mesh(directory / "m.meshb", two_tets(), 4);
  bytes = bytes_of(directory / "m.meshb");
  for (const std::int64_t huge :
       {std::int64_t{1} << 61, std::int64_t{0x0CCCCCCCCCCCCCCE}, std::int64_t{1} << 32}) {
    expect_contains(about(with_value(bytes, find_keyword(bytes, 8) + 12, huge)), "Tetrahedra");
  }
}

TEST_F(GmfBinary, ChainMustMoveForward) {
  const std::size_t tets = find_keyword(bytes, 8);
  for (const auto next : {std::int32_t{8}, static_cast<std::int32_t>(tets), -8, 0}) {
    expect_contains(about(with_value(bytes, tets + 4, next)), "Tetrahedra: the next keyword's position");
  }
}

TEST_F(GmfBinary, DuplicateSectionsAreRefused) {
  expect_contains(about(with_section(13, 0, "")), "Corners: appears twice");
  expect_contains(about(with_section(3, 3, "")), "Dimension: appears twice");
}

TEST_F(GmfBinary, UnknownSectionsAreSkipped) {
  put_bytes(directory / "m.meshb", with_section(60, 1, std::string(24, 'x')));
  expect_equal(read_gmf_mesh(directory / "m.meshb"), two_tets());
  put_bytes(directory / "m.meshb", with_section(9999, -5, "anything"));
  expect_equal(read_gmf_mesh(directory / "m.meshb"), two_tets());
}

TEST_F(GmfBinary, FloatingPointPrecisionOverridesTheVersion) {
  write_gmf_mesh(directory / "m.meshb", two_tets(), 1);
  bytes = with_value(bytes_of(directory / "m.meshb"), 4, 2);  // versions 1 and 2 differ in the reals only
  put_bytes(directory / "m.meshb", with_section(155, 32, ""));
  expect_equal(read_gmf_mesh(directory / "m.meshb"), two_tets());
}

TEST_F(GmfBinary, OtherElementsAreCounted) {
  put_bytes(directory / "m.meshb", with_section(7, 2, std::string(40, '\0')));
  EXPECT_TRUE(dropped(read_mesh_contents(directory / "m.meshb"), "quadrilaterals", 2));
  for (std::uint64_t part : {0u, 1u})  // in every range those of the whole file
    EXPECT_TRUE(
        dropped(read_mesh_range(directory / "m.meshb", {part, 1, part, 1, part, 2}), "quadrilaterals", 2));
  put_bytes(directory / "m.meshb", with_section(7, 0, ""));
  EXPECT_TRUE(read_mesh_contents(directory / "m.meshb").dropped.empty());
}

TEST(GmfText, OtherElementsAreCounted) {
  const TemporaryDirectory directory;
  write_gmf_mesh(directory / "m.mesh", two_tets());
  std::string text = bytes_of(directory / "m.mesh");
  text.insert(text.rfind("End"), "TrianglesP2\n1\n1 2 3 4 5 1 9\nEdgesP2\n2\n1 2 3 0\n2 3 4 0\n");
  put_bytes(directory / "m.mesh", text);
  MeshCollector stream;
  for (const MeshContents& c :
       {read_mesh_contents(directory / "m.mesh"), stream_mesh(directory / "m.mesh", stream)}) {
    EXPECT_TRUE(dropped(c, "triangles of second order", 1));
    EXPECT_TRUE(dropped(c, "edges of second order", 2));
  }
}

TEST_F(GmfBinary, OtherVolumeElementsAreRefused) {
  expect_contains(about(with_section(10, 1, std::string(36, '\0'))), "Hexahedra: the mesh has 1 of them");
  put_bytes(directory / "m.meshb", with_section(9, 0, ""));
  EXPECT_NO_THROW(read_gmf_mesh(directory / "m.meshb"));
}

TEST_F(GmfBinary, MissingVerticesAreNamed) {
  const std::size_t vertices = find_keyword(bytes, 4);
  expect_contains(about(with_value(bytes, vertices, 9999)), "Vertices: are missing");
}

TEST_F(GmfBinary, RewritingGivesTheSameBytes) {
  write_gmf_mesh(directory / "again.meshb", read_gmf_mesh(directory / "m.meshb"));
  EXPECT_EQ(bytes_of(directory / "again.meshb"), bytes);
}

TEST(GmfSolution, UnknownFieldTypesAreNamed) {
  const TemporaryDirectory directory;
  put_bytes(directory / "s.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n1\n2 1 4\n1 2\nEnd\n");
  expect_contains(message_of([&] { read_gmf_solution(directory / "s.sol"); }),
                  "SolAtVertices: field 2 has type 4");
  put_bytes(directory / "s.sol", "MeshVersionFormatted 2\nDimension 3\nEnd\n");
  expect_contains(message_of([&] { read_gmf_solution(directory / "s.sol"); }), "SolAtVertices: is missing");
}

TEST(GmfWriter, RefusesToRoundTetsAway) {
  const TemporaryDirectory directory;
  MeshData mesh = two_tets();
  for (Point& p : mesh.points) p.x += 1e8;
  expect_contains(message_of([&] { write_gmf_mesh(directory / "m.meshb", mesh, 1); }),
                  "tet 1: would lose its volume");
  EXPECT_EQ(directory.num_entries(), 0u);
  EXPECT_NO_THROW(write_gmf_mesh(directory / "m.meshb", mesh, 2));
}

TEST(GmfWriter, RefusesVersionsThatCannotHoldTheData) {
  const TemporaryDirectory directory;
  MeshData mesh = two_tets();
  EXPECT_THROW(write_gmf_mesh(directory / "m.meshb", mesh, 5), InputError);
  mesh.points[0].x = 1e300;
  EXPECT_THROW(write_gmf_mesh(directory / "m.meshb", mesh, 1), InputError);
  EXPECT_EQ(directory.num_entries(), 0u);
}

TEST(GmfWriter, LargeMeshPassesTheBuffers) {
  const TemporaryDirectory directory;
  MeshData mesh;
  for (int i = 0; i < 200000; ++i) {
    mesh.points.push_back({1.0 * i, 1.0 / (i + 1), -1.0 * i});
    mesh.point_refs.push_back(i);
  }
  write_gmf_mesh(directory / "m.meshb", mesh);
  const MeshData read = read_gmf_mesh(directory / "m.meshb");
  EXPECT_EQ(read.points, mesh.points);
  EXPECT_EQ(read.point_refs, mesh.point_refs);
}

TEST(GmfWriter, FailureKeepsTheOldFileAndLeavesNothingElse) {
  const TemporaryDirectory directory;
  put_bytes(directory / "m.meshb", "precious");
  MeshData mesh = two_tets();
  mesh.points[4].z = 1e300;
  EXPECT_THROW(write_gmf_mesh(directory / "m.meshb", mesh, 1), InputError);
  EXPECT_EQ(bytes_of(directory / "m.meshb"), "precious");
  EXPECT_EQ(directory.num_entries(), 1u);
}

/// Lets files grow to a limit only, like a disk that fills up.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit limit{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  void (*old_handler_)(int);
  rlimit old_{};
};

TEST(GmfWriter, FullDiskIsReportedAndLeavesNothing) {
  const TemporaryDirectory directory;
  MeshData mesh;
  mesh.points.resize(300000);
  mesh.point_refs.resize(300000);
  for (const char* name :
       {"m.meshb", "m.mesh", "m.vtu", "m.msh", "m.lb8.ugrid", "m.su2", "m.ply", "m.cgns"}) {
    const FileSizeLimit limit(100000);
    const std::string message = message_of([&] { write_mesh(directory / name, mesh); });
    // CGNS has its own words for it.
    expect_contains(message, std::string(name) == "m.cgns" ? "m.cgns: " : "cannot write: File too large");
    EXPECT_EQ(directory.num_entries(), 0u);
  }
}

/// Root may write anywhere: gives its rights up for a while.
class AsOrdinaryUser {
 public:
  AsOrdinaryUser() : changed_(::geteuid() == 0 && ::seteuid(65534) == 0) {}
  ~AsOrdinaryUser() {
    if (changed_ && ::seteuid(0) != 0) std::abort();
  }

 private:
  bool changed_;
};

TEST(GmfWriter, UnwritableDirectoryIsReported) {
  const TemporaryDirectory directory;
  fs::permissions(directory.path(), fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read |
                                        fs::perms::others_exec);
  {
    const AsOrdinaryUser ordinary;
    expect_contains(message_of([&] { write_gmf_mesh(directory / "m.meshb", two_tets()); }),
                    "m.meshb: cannot write: Permission denied");
  }
  fs::permissions(directory.path(), fs::perms::owner_all);
  EXPECT_EQ(directory.num_entries(), 0u);
}

TEST(GmfWriter, OddTargetsAreReported) {
  const TemporaryDirectory directory;
  const auto write_to = [&](const fs::path& path) {
    return message_of([&] { write_gmf_mesh(path, two_tets()); });
  };
  expect_contains(write_to(directory / "none/m.meshb"), "No such file or directory");
  fs::create_directory(directory / "dir.meshb");
  expect_contains(write_to(directory / "dir.meshb"), "Is a directory");
  expect_contains(write_to("/dev/null"), "not a regular file");
  EXPECT_EQ(directory.num_entries(), 1u);
}

TEST(GmfWriter, FollowsASymbolicLink) {
  const TemporaryDirectory directory;
  put_bytes(directory / "real.meshb", "old");
  fs::create_symlink("real.meshb", directory / "link.meshb");
  write_gmf_mesh(directory / "link.meshb", two_tets());
  EXPECT_TRUE(fs::is_symlink(directory / "link.meshb"));
  expect_equal(read_gmf_mesh(directory / "real.meshb"), two_tets());
}

TEST(MeshFile, ChoosesTheFormatByExtension) {
  const TemporaryDirectory directory;
  SolutionData fields{5, {{Field::Kind::scalar, {1, 2, 3, 4, 5}, "h"}}};
  for (const char* extension : {".meshb", ".mesh"}) {
    write_mesh(directory / ("m" + std::string(extension)), two_tets(), &fields);
    expect_equal(read_mesh(directory / ("m" + std::string(extension))), two_tets());
  }
  expect_equal(read_solution(directory / "m.solb"), fields);
  expect_equal(read_solution(directory / "m.sol"), fields);
  EXPECT_TRUE(bytes_of(directory / "m.sol").starts_with("MeshVersionFormatted"));
}

TEST(MeshFile, ComplainsAboutExtensionsAndMissingFiles) {
  const TemporaryDirectory directory;
  expect_contains(message_of([] { read_mesh("x.xyz"); }), "x.xyz: unexpected extension .xyz");
  expect_contains(message_of([] { read_mesh("x.solb"); }), "unexpected extension .solb");
  expect_contains(message_of([] { read_solution("x"); }), "no extension");
  expect_contains(message_of([] { write_mesh("x.sol", two_tets()); }), "unexpected extension .sol");
  expect_contains(message_of([] { write_solution("x.mesh", three_fields()); }), "unexpected extension .mesh");
  expect_contains(message_of([&] { read_mesh(directory / "none.meshb"); }),
                  "none.meshb: cannot read: No such file or directory");
  fs::create_directory(directory / "dir.mesh");
  expect_contains(message_of([&] { read_mesh(directory / "dir.mesh"); }), "not a regular file");
}

}  // namespace
}  // namespace weft::meshing::gmf_test
