// SU2: lines KEY= VALUE, some of them followed by rows of numbers. Elements may stand before the points.
#include "meshing/io/su2.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/text_output.h"

namespace weft::meshing {
namespace {

// VTK's numbers.
constexpr std::int64_t kTriangle = 5, kTetrahedron = 10;

struct ElementType {
  std::int64_t code;
  int dimension, nodes;
  const char* name;
};
constexpr std::array<ElementType, 8> kElementTypes = {{{1, 0, 1, "points"},
                                                       {3, 1, 2, "lines"},
                                                       {kTriangle, 2, 3, "triangles"},
                                                       {9, 2, 4, "quadrilaterals"},
                                                       {kTetrahedron, 3, 4, "tetrahedra"},
                                                       {12, 3, 8, "hexahedra"},
                                                       {13, 3, 6, "prisms"},
                                                       {14, 3, 5, "pyramids"}}};

class Su2Reader {
 public:
  Su2Reader(Cursor& in, MeshContents& contents)
      : in_(in), mesh_(contents.mesh), contents_(contents), markers_(2, contents.names) {
    in_.set_comment('%');
  }

  void read() {
    for (in_.skip_blanks(); !in_.at_end(); in_.skip_blanks()) read_line(in_.line());
    in_.enter("");
    if (!has_dimension_) in_.fail("not an SU2 mesh: no NDIME=");
    if (!has_points_) in_.fail("NPOIN= is missing");
    if (!has_elements_) in_.fail("NELEM= is missing");
    if (num_markers_ != expected_markers_) {
      in_.fail("has " + std::to_string(num_markers_) + " markers instead of " +
               std::to_string(expected_markers_));
    }
    check_indices("NELEM", mesh_.tets);
    check_indices("MARKER_ELEMS", mesh_.triangles);
    in_.enter("");
    if (!has_markers_) in_.fail("NMARK= is missing");
  }

 private:
  void read_line(std::string_view line) {
    in_.enter("");
    line = line.substr(0, line.find('%'));
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) in_.fail("expected KEY= VALUE, found " + quoted(trimmed(line)));
    const std::string key(trimmed(line.substr(0, equals)));
    const std::string_view value = trimmed(line.substr(equals + 1));
    in_.enter(key);
    if (key == "NDIME") {
      if (number(value) != 3) in_.fail("the mesh has " + quoted(value) + " dimensions; weft adapts volumes");
      has_dimension_ = true;
    } else if (key == "NZONE") {
      if (number(value) != 1) in_.fail("files of several zones are not read");
    } else if (key == "NELEM") {
      read_elements(number(value));
    } else if (key == "NPOIN") {
      read_points(number(value.substr(0, value.find_first_of(" \t"))));
    } else if (key == "NMARK") {
      expected_markers_ = number(value);
      has_markers_ = true;
    } else if (key == "MARKER_TAG") {
      marker_ = markers_.ref(value);
    } else if (key == "MARKER_ELEMS") {
      read_marker(number(value));
    } else {
      read_other(key);
    }
  }

  std::uint64_t number(std::string_view text) const {
    const auto value = parse_integer(text);
    if (!value || *value < 0) in_.fail("expected a count, found " + quoted(text));
    return static_cast<std::uint64_t>(*value);
  }

  const ElementType& read_type() {
    const std::int64_t code = in_.text_integer();
    const auto type = std::ranges::find(kElementTypes, code, &ElementType::code);
    if (type == kElementTypes.end()) in_.fail("element type " + std::to_string(code) + " is unknown");
    return *type;
  }

  /// Whether these are below the number of points is known only at the end.
  template <std::size_t N>
  std::array<std::uint32_t, N> read_nodes() {
    std::array<std::uint32_t, N> nodes;
    for (std::uint32_t& node : nodes) node = in_.index(in_.text_integer(), 0, 0xFFFFFFFEu);
    return nodes;
  }

  void read_elements(std::uint64_t count) {
    if (std::exchange(has_elements_, true)) in_.fail("appears twice");
    require_rows(count, 2);
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      const ElementType& type = read_type();
      if (type.code == kTetrahedron) {
        mesh_.tets.push_back(read_nodes<4>());
      } else if (type.dimension == 3) {
        contents_.drop_volumes(type.name, 1);
      } else {
        in_.fail(std::string(type.name) + " among the volume elements");
      }
      in_.line();  // may hold the element's number
    }
  }

  void read_points(std::uint64_t count) {
    if (std::exchange(has_points_, true)) in_.fail("appears twice");
    require_rows(in_.entity_count(count), 5);
    mesh_.points.resize(count);
    for (Point& p : mesh_.points) {
      in_.next_row();
      for (int c = 0; c < 3; ++c) p[c] = in_.finite(in_.text_real());
      in_.line();  // may hold the point's number
    }
  }

  void read_marker(std::uint64_t count) {
    require_rows(count, 2);
    ++num_markers_;
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      const ElementType& type = read_type();
      if (type.code == kTriangle) {
        mesh_.triangles.push_back(read_nodes<3>());
        mesh_.triangle_refs.push_back(marker_);
      } else if (type.dimension < 3) {
        contents_.drop(std::string(type.name) + " in markers");
      } else {
        in_.fail(std::string(type.name) + " in a marker");
      }
      in_.line();
    }
  }

  void require_rows(std::uint64_t count, std::uint64_t least_bytes) const { in_.require(count, least_bytes); }

  /// Periodic boundaries, deformation boxes, send-receive lists: their rows do not look like KEY= VALUE.
  void read_other(const std::string& key) {
    if (key == "SEND_RECV") return;  // says to which partition a marker goes
    contents_.drop("entries " + key);
    for (;;) {
      in_.skip_blanks();
      const std::size_t begin = in_.position();
      if (in_.at_end()) return;
      if (in_.line().find('=') == std::string_view::npos) continue;
      in_.seek(begin);
      return;
    }
  }

  template <class Elements>
  void check_indices(const char* name, const Elements& elements) {
    in_.enter(name);
    for (const auto& element : elements) {
      in_.next_row();
      for (const std::uint32_t v : element) in_.index(v, 0, mesh_.points.size());
    }
  }

  Cursor& in_;
  MeshData& mesh_;
  MeshContents& contents_;
  RefNumbering markers_;
  bool has_dimension_ = false, has_points_ = false, has_elements_ = false, has_markers_ = false;
  std::uint64_t num_markers_ = 0, expected_markers_ = 0;
  std::int32_t marker_ = 0;
};

template <std::size_t N>
void write_element(TextOutput<>& text, std::int64_t type, const std::array<std::uint32_t, N>& nodes) {
  text.number(type);
  for (const std::uint32_t v : nodes) text.number(v);
}

/// Tags are single words that begin no comment.
std::string marker_tag(std::string name) {
  for (char& c : name) {
    if (is_space(c) || c == '%' || c == '=') c = '_';
  }
  return name;
}

}  // namespace

MeshContents read_su2(const std::filesystem::path& path) {
  const FileBytes file(path);
  Cursor in(file.name(), file.bytes());
  MeshContents contents;
  Su2Reader(in, contents).read();
  contents.complete();
  return contents;
}

void write_su2(const std::filesystem::path& path, const MeshView& contents, const WriteOptions&) {
  check_lengths(contents.mesh, contents.fields);
  const MeshData& mesh = contents.mesh;
  AtomicFile out(path);
  TextOutput text(out);
  text.line("NDIME= 3\nNELEM= " + std::to_string(mesh.tets.size()));
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    write_element(text, kTetrahedron, mesh.tets[i]);
    text.number(i);
    text.end_line();
  }
  text.line("NPOIN= " + std::to_string(mesh.points.size()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    for (int c = 0; c < 3; ++c) text.number(mesh.points[i][c]);
    text.number(i);
    text.end_line();
  }
  const auto markers = indices_by_ref(mesh.triangle_refs);
  text.line("NMARK= " + std::to_string(markers.size()));
  for (const auto& [ref, triangles] : markers) {
    text.line("MARKER_TAG= " + marker_tag(contents.names.name(2, ref)));
    text.line("MARKER_ELEMS= " + std::to_string(triangles.size()));
    for (const std::uint32_t i : triangles) {
      write_element(text, kTriangle, mesh.triangles[i]);
      text.end_line();
    }
  }
  out.commit();
}

}  // namespace weft::meshing
