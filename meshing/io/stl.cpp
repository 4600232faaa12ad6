// Binary STL is an 80-byte title, a count and 50 bytes a triangle; ASCII a fixed sequence of words.
#include "meshing/io/stl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <string_view>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/point_merger.h"
#include "meshing/io/files/text_output.h"

namespace weft::meshing {
namespace {

constexpr std::size_t kTitleSize = 80, kHeaderSize = 84, kFacetSize = 50, kNormalSize = 12;

bool equal_without_case(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::ranges::equal(a, b, {}, lower, lower);
}

/// Collects triangles with the points they share.
class Facets {
 public:
  explicit Facets(MeshContents& contents) : contents_(contents), points_(contents.mesh.points) {}

  void reserve(std::size_t triangles) {
    contents_.mesh.triangles.reserve(triangles);
    contents_.mesh.triangle_refs.reserve(triangles);
    points_.reserve(triangles / 2);
  }
  void add(const std::array<Point, 3>& corners, std::int32_t ref) {
    std::array<std::uint32_t, 3> triangle;
    for (std::size_t i = 0; i < 3; ++i) triangle[i] = points_.index(corners[i]);
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
      return contents_.drop("triangles with two equal corners");
    }
    contents_.mesh.triangles.push_back(triangle);
    contents_.mesh.triangle_refs.push_back(ref);
  }

 private:
  MeshContents& contents_;
  PointMerger points_;
};

/// Whether the size is that of a binary file with the count that stands behind the title.
bool is_binary(std::string_view bytes) {
  if (bytes.size() < kHeaderSize) return false;
  const std::uint64_t count = load<std::uint32_t>(bytes.data() + kTitleSize, false);
  return bytes.size() == kHeaderSize + count * kFacetSize;
}

void read_binary(Cursor& in, MeshContents& contents) {
  in.seek(kTitleSize);
  const std::uint64_t count = in.value<std::uint32_t>();
  in.enter("Facet");
  in.entity_count(3 * count);
  Facets facets(contents);
  facets.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    in.next_row();
    in.take(kNormalSize);
    std::array<Point, 3> corners;
    for (Point& p : corners) {
      for (int c = 0; c < 3; ++c) p[c] = in.coordinate(in.value<float>());
    }
    facets.add(corners, in.value<std::uint16_t>());
  }
}

class AsciiReader {
 public:
  AsciiReader(Cursor& in, MeshContents& contents) : in_(in), facets_(contents), refs_(2, contents.names) {}

  void read() {
    in_.enter("Facet");
    std::string_view word = in_.word();
    while (!word.empty()) {
      if (!equal_without_case(word, "solid")) in_.fail("expected solid, found " + quoted(word));
      read_solid();
      word = in_.word();
    }
  }

 private:
  void read_solid() {
    const std::string name(trimmed(in_.line()));
    const std::int32_t ref = refs_.ref(name);
    std::string_view word = in_.word();
    for (; equal_without_case(word, "facet"); word = in_.word()) read_facet(ref);
    if (!equal_without_case(word, "endsolid")) in_.fail("expected facet or endsolid, found " + quoted(word));
    in_.line();  // the name again
  }

  void read_facet(std::int32_t ref) {
    in_.next_row();
    expect("normal");
    for (int c = 0; c < 3; ++c) in_.word();  // may be anything: the triangle has a normal of its own
    expect("outer");
    expect("loop");
    std::array<Point, 3> corners;
    for (Point& p : corners) {
      expect("vertex");
      for (int c = 0; c < 3; ++c) p[c] = in_.coordinate(in_.text_real());
    }
    expect("endloop");
    expect("endfacet");
    facets_.add(corners, ref);
  }

  void expect(std::string_view expected) {
    const std::string_view word = in_.word();
    if (!equal_without_case(word, expected)) {
      in_.fail("expected " + std::string(expected) + ", found " + quoted(word));
    }
  }

  Cursor& in_;
  Facets facets_;
  RefNumbering refs_;
};

Vec unit_normal(const std::array<Point, 3>& p) {
  const Vec normal = cross(p[1] - p[0], p[2] - p[0]);
  const double length = norm(normal);
  return length > 0 && std::isfinite(length) ? (1 / length) * normal : Vec{};
}

std::array<Point, 3> corners_of(const MeshData& mesh, std::size_t i) {
  const auto& t = mesh.triangles[i];
  return {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
}

void write_vector(const std::filesystem::path& path, AtomicFile& out, const Point& p) {
  for (int c = 0; c < 3; ++c) {
    if (std::abs(p[c]) > std::numeric_limits<float>::max()) {
      throw InputError(path.string(), "", "a coordinate is too large for the 32-bit reals of binary STL");
    }
    out.write_value(static_cast<float>(p[c]));
  }
}

void write_binary(const std::filesystem::path& path, const MeshData& mesh) {
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(path.string(), "", "too many triangles for STL");
  }
  AtomicFile out(path);
  std::string title = "binary STL written by weft";  // must not begin with "solid"
  title.resize(kTitleSize, ' ');
  out.write(title);
  out.write_value(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::array<Point, 3> corners = corners_of(mesh, i);
    write_vector(path, out, unit_normal(corners));
    for (const Point& p : corners) write_vector(path, out, p);
    const std::int32_t ref = mesh.triangle_refs[i];
    out.write_value(static_cast<std::uint16_t>(std::in_range<std::uint16_t>(ref) ? ref : 0));
  }
  out.commit();
}

void write_ascii_facet(TextOutput<>& text, const std::array<Point, 3>& corners) {
  const Vec n = unit_normal(corners);
  text.word("facet normal");
  text.numbers(n.x, n.y, n.z);
  text.end_line();
  text.line("outer loop");
  for (const Point& p : corners) {
    text.word("vertex");
    text.numbers(p.x, p.y, p.z);
    text.end_line();
  }
  text.line("endloop");
  text.line("endfacet");
}

void write_ascii(const std::filesystem::path& path, const MeshView& contents) {
  const MeshData& mesh = contents.mesh;
  AtomicFile out(path);
  TextOutput text(out);
  for (const auto& [ref, triangles] : indices_by_ref(mesh.triangle_refs)) {
    const std::string name = contents.names.name(2, ref);
    text.line("solid " + name);
    for (const std::uint32_t i : triangles) write_ascii_facet(text, corners_of(mesh, i));
    text.line("endsolid " + name);
  }
  if (mesh.triangles.empty()) text.line("solid empty\nendsolid empty");
  out.commit();
}

}  // namespace

MeshContents read_stl(const std::filesystem::path& path) {
  const FileBytes file(path);
  Cursor in(file.name(), file.bytes());
  MeshContents contents;
  if (is_binary(file.bytes())) {
    read_binary(in, contents);
  } else if (in.skip_blanks(); in.rest().size() >= 5 && equal_without_case(in.rest().substr(0, 5), "solid")) {
    AsciiReader(in, contents).read();
  } else {
    throw InputError(file.name(), "",
                     "not an STL file: its size does not fit a binary one, nor does it begin with solid");
  }
  contents.complete();
  return contents;
}

void write_stl(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options) {
  check_lengths(contents.mesh, contents.fields);
  if (options.encoding == WriteOptions::Encoding::ascii) return write_ascii(path, contents);
  write_binary(path, contents.mesh);
}

}  // namespace weft::meshing
