// OBJ line by line: the first word says what it is.
#include "meshing/io/obj.h"

#include <cstdint>
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

/// The words of one line.
class LineWords {
 public:
  explicit LineWords(std::string_view line) : line_(line.substr(0, line.find('#'))) {}
  std::string_view next() {
    std::size_t begin = 0;
    while (begin < line_.size() && is_space(line_[begin])) ++begin;
    std::size_t end = begin;
    while (end < line_.size() && !is_space(line_[end])) ++end;
    const std::string_view word = line_.substr(begin, end - begin);
    line_.remove_prefix(end);
    return word;
  }
  std::string_view rest() const { return trimmed(line_); }

 private:
  std::string_view line_;
};

class ObjReader {
 public:
  ObjReader(Cursor& in, MeshContents& contents)
      : in_(in), contents_(contents), face_refs_(2, contents.names), line_refs_(1, contents.names) {}

  void read() {
    in_.enter("line");
    while (!in_.at_end()) {
      in_.next_row();
      read_line(logical_line());
    }
    if (contents_.mesh.points.empty()) {
      in_.enter("");
      in_.fail("not an OBJ file, or one without points");
    }
    check_largest_index();
    polygons_.unfold(contents_.mesh);
  }

 private:
  /// A line with those that continue it: a backslash at its end says so, but for that of a comment, which
  /// may be the name of a folder.
  std::string_view logical_line() {
    std::string_view line = in_.line();
    if (!continues(line)) return line;
    joined_.clear();
    for (;; line = in_.line()) {
      const bool more = continues(line);
      joined_ += more ? line.substr(0, line.find_last_of('\\')) : line;
      if (!more || in_.at_end()) return joined_;
      joined_ += ' ';
      in_.next_row();
    }
  }

  static bool continues(std::string_view line) {
    return trimmed(line).ends_with('\\') && line.find('#') == std::string_view::npos;
  }

  void read_line(std::string_view text) {
    LineWords words(text);
    const std::string_view key = words.next();
    if (key.empty()) return;
    if (key == "v") return read_point(words);
    if (key == "f") return read_face(words);
    if (key == "l") return read_polyline(words);
    if (key == "g" || key == "o") return begin_group(key, words.rest());
    count_dropped(key);
  }

  void count_dropped(std::string_view key) {
    if (key == "vt") return contents_.drop("texture coordinates");
    if (key == "vn") return contents_.drop("normals");
    if (key == "usemtl") return contents_.drop("uses of materials");
    if (key == "p") return contents_.drop("point elements");
    for (const std::string_view ignored :
         {"mtllib", "s",        "vp",       "cstype", "deg",        "curv",      "curv2", "surf",
          "parm",   "end",      "trim",     "hole",   "scrv",       "sp",        "con",   "mg",
          "bevel",  "c_interp", "d_interp", "lod",    "shadow_obj", "trace_obj", "ctech", "stech"}) {
      if (key == ignored) return contents_.drop("lines beginning with " + std::string(key));
    }
    in_.fail("begins with " + quoted(key) + ", which OBJ does not know");
  }

  void read_point(LineWords& words) {
    Point p;
    for (int c = 0; c < 3; ++c) {
      const std::string_view word = words.next();
      const auto value = parse_real(word);
      if (!value) in_.fail("expected three coordinates");
      p[c] = in_.coordinate(*value);
    }
    contents_.mesh.points.push_back(p);
    in_.entity_count(contents_.mesh.points.size());
  }

  /// A corner such as 7, -1, 7/1, 7//3: only its point matters. Points may also follow their use.
  std::uint32_t corner(std::string_view word) {
    const auto index = parse_integer(word.substr(0, word.find('/')));
    if (!index) in_.fail("expected the index of a point, found " + quoted(word));
    const auto known = static_cast<std::int64_t>(contents_.mesh.points.size());
    const std::int64_t number = *index < 0 ? *index + known + 1 : *index;
    if (number < 1 || number > 0xFFFFFFFE) in_.fail("vertex index " + std::string(word) + " is out of range");
    if (number > largest_) {
      largest_ = number;
      largest_line_ = in_.row();
    }
    return static_cast<std::uint32_t>(number - 1);
  }

  void read_corners(LineWords& words, std::size_t least) {
    corners_.clear();
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      corners_.push_back(corner(word));
    }
    if (corners_.size() < least) in_.fail("has too few points");
  }

  void read_face(LineWords& words) {
    read_corners(words, 3);
    if (corners_.size() > 3) contents_.drop("polygons (cut into triangles)");
    polygons_.add(corners_, face_refs_.ref(group_), contents_.mesh);
  }

  void read_polyline(LineWords& words) {
    read_corners(words, 2);
    const std::int32_t ref = line_refs_.ref(group_);
    for (std::size_t i = 1; i < corners_.size(); ++i) {
      contents_.mesh.edges.push_back({corners_[i - 1], corners_[i]});
      contents_.mesh.edge_refs.push_back(ref);
    }
  }

  /// Groups lie in objects: an object's name counts where it has no groups.
  void begin_group(std::string_view key, std::string_view name) {
    if (key == "g") has_groups_ = true;
    if (key == "g" || !has_groups_) group_ = name;
  }

  void check_largest_index() {
    const std::size_t known = contents_.mesh.points.size();
    if (static_cast<std::uint64_t>(largest_) <= known) return;
    in_.enter("line " + std::to_string(largest_line_));
    in_.index(largest_, 1, known);
  }

  Cursor& in_;
  MeshContents& contents_;
  RefNumbering face_refs_, line_refs_;
  std::string joined_;  ///< the latest line that was continued
  std::string group_;
  bool has_groups_ = false;
  std::vector<std::uint32_t> corners_;
  Polygons polygons_;
  std::int64_t largest_ = 0;
  std::uint64_t largest_line_ = 0;
};

template <class Elements>
void write_groups(TextOutput<>& text, const RefNames& names, int dimension, std::string_view key,
                  const Elements& elements, const std::vector<std::int32_t>& refs) {
  for (const auto& [ref, indices] : indices_by_ref(refs)) {
    text.line("g " + names.name(dimension, ref));
    for (const std::uint32_t i : indices) {
      text.word(key);
      for (const std::uint32_t vertex : elements[i]) text.number(std::uint64_t{vertex} + 1);
      text.end_line();
    }
  }
}

}  // namespace

MeshContents read_obj(const std::filesystem::path& path) {
  const FileBytes file(path);
  Cursor in(file.name(), file.bytes());
  MeshContents contents;
  ObjReader(in, contents).read();
  contents.complete();
  return contents;
}

void write_obj(const std::filesystem::path& path, const MeshView& contents, const WriteOptions&) {
  check_lengths(contents.mesh, contents.fields);
  const MeshContents surface = surface_of(contents);
  AtomicFile out(path);
  TextOutput text(out);
  text.line("# written by weft");
  for (const Point& p : surface.mesh.points) {
    text.word("v");
    text.numbers(p.x, p.y, p.z);
    text.end_line();
  }
  write_groups(text, surface.names, 2, "f", surface.mesh.triangles, surface.mesh.triangle_refs);
  write_groups(text, surface.names, 1, "l", surface.mesh.edges, surface.mesh.edge_refs);
  out.commit();
}

}  // namespace weft::meshing
