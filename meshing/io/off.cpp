// Counts first, then a line for each point and each face.
#include "meshing/io/off.h"

#include <string>
#include <string_view>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/text_output.h"
#include "meshing/mesh/polygon.h"

namespace weft::meshing {
namespace {

class Reader {
 public:
  Reader(Cursor& in, MeshContents& contents) : in_(in), contents_(contents) {}

  void read() {
    in_.set_comment('#');
    in_.enter("header");
    read_keyword();
    const std::uint64_t points = in_.entity_count(in_.text_count()), faces = in_.text_count();
    drop_rest_of_line();  // the number of edges, which nobody keeps
    in_.require(points, 6);
    in_.require(faces, 2);
    in_.enter("vertex");
    for (std::uint64_t i = 0; i < points; ++i) read_point();
    in_.enter("face");
    for (std::uint64_t i = 0; i < faces; ++i) read_face();
    polygons_.unfold(contents_.mesh);
  }

 private:
  /// The keyword may be missing; letters before OFF say what stands behind a point's coordinates.
  void read_keyword() {
    const std::size_t start = in_.position();
    const std::string_view word = in_.word();
    if (word == "OFF" || word == "COFF" || word == "NOFF" || word == "CNOFF") {
      const std::size_t behind = in_.position();
      if (in_.word() == "BINARY") in_.fail("binary OFF files are not read: write it as ASCII");
      in_.seek(behind);
    } else if (parse_integer(word)) {
      in_.seek(start);
    } else {
      in_.fail("not an OFF file with points of three coordinates: begins with " + quoted(word));
    }
  }

  /// Whether something stood there.
  bool drop_rest_of_line() {
    const std::string_view rest = in_.line();
    return !trimmed(rest.substr(0, rest.find('#'))).empty();
  }

  void read_point() {
    in_.next_row();
    Point p;
    for (int c = 0; c < 3; ++c) p[c] = in_.coordinate(in_.text_real());
    contents_.mesh.points.push_back(p);
    if (drop_rest_of_line()) contents_.drop("colours or normals of points");
  }

  void read_face() {
    in_.next_row();
    const std::uint64_t size = in_.text_count();
    if (size < 2) in_.fail("has too few points");
    in_.require(size, 2);
    corners_.clear();
    for (std::uint64_t i = 0; i < size; ++i)
      corners_.push_back(in_.index(in_.text_integer(), 0, contents_.mesh.points.size()));
    if (drop_rest_of_line()) contents_.drop("colours of faces");
    if (size == 2) {
      contents_.mesh.edges.push_back({corners_[0], corners_[1]});
      contents_.mesh.edge_refs.push_back(0);
    }
    if (size > 3) contents_.drop("polygons (cut into triangles)");
    polygons_.add(corners_, 0, contents_.mesh);
  }

  Cursor& in_;
  MeshContents& contents_;
  std::vector<std::uint32_t> corners_;
  Polygons polygons_;
};

}  // namespace

MeshContents read_off(const std::filesystem::path& path) {
  const FileBytes file(path);
  Cursor in(file.name(), file.bytes());
  MeshContents contents;
  Reader(in, contents).read();
  contents.complete();
  return contents;
}

void write_off(const std::filesystem::path& path, const MeshView& contents, const WriteOptions&) {
  check_lengths(contents.mesh, contents.fields);
  const MeshContents surface = surface_of(contents);
  AtomicFile out(path);
  TextOutput text(out);
  text.line("OFF");
  text.numbers(std::uint64_t{surface.mesh.points.size()}, std::uint64_t{surface.mesh.triangles.size()}, 0);
  text.end_line();
  for (const Point& p : surface.mesh.points) {
    text.numbers(p.x, p.y, p.z);
    text.end_line();
  }
  for (const auto& [a, b, c] : surface.mesh.triangles) {
    text.numbers(3, a, b, c);
    text.end_line();
  }
  out.commit();
}

}  // namespace weft::meshing
