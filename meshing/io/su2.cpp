// SU2: lines KEY= VALUE, some of them followed by rows of numbers. Elements may stand before the points.
#include "meshing/io/su2.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/mesh_stream.h"
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
  Su2Reader(Cursor& in, MeshContents& contents, MeshStream& stream)
      : in_(in),
        contents_(contents),
        markers_(2, contents.names),
        points_(stream, &MeshStream::take_points),
        tets_(stream, &MeshStream::take_tets),
        boundary_(stream) {
    in_.set_comment('%');
  }

  /// Known when all has been read.
  std::uint64_t num_points() const { return points_.count(); }
  /// No tet, and no triangle of a marker, has a vertex above it.
  std::uint32_t greatest_vertex() const { return greatest_; }
  bool has_markers() const { return has_markers_; }

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
    points_.pass();
    tets_.pass();
    boundary_.pass();
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
        const auto tet = read_nodes<4>();
        greatest_ = std::max(greatest_, std::ranges::max(tet));
        tets_.add(tet);
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
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      Point p;
      for (int c = 0; c < 3; ++c) p[c] = in_.coordinate(in_.text_real());
      points_.add(p);
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
        const auto triangle = read_nodes<3>();
        greatest_ = std::max(greatest_, std::ranges::max(triangle));
        boundary_.rows.rows.triangles.push_back(triangle);
        boundary_.rows.rows.triangle_refs.push_back(marker_);
        boundary_.pass_if_full();
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

  Cursor& in_;
  MeshContents& contents_;
  RefNumbering markers_;
  StreamedRows<Point> points_;
  StreamedRows<std::array<std::uint32_t, 4>> tets_;
  StreamedBoundary boundary_;
  std::uint32_t greatest_ = 0;
  bool has_dimension_ = false, has_points_ = false, has_elements_ = false, has_markers_ = false;
  std::uint64_t num_markers_ = 0, expected_markers_ = 0;
  std::int32_t marker_ = 0;
};

/// Finds the first tet with a vertex that the file has not, else the first such triangle of a marker, since
/// points may come behind them. Of one kind of elements: tets, or triangles.
class VertexChecker final : public MeshStream {
 public:
  VertexChecker(const std::string& file, bool of_tets, std::uint64_t num_points)
      : in_(file, {}), of_tets_(of_tets), num_points_(num_points) {
    in_.enter(of_tets ? "NELEM" : "MARKER_ELEMS");
  }

  void take_tets(std::vector<std::array<std::uint32_t, 4>> rows) override {
    if (of_tets_) check(rows);
  }
  void take_boundary(BoundaryRows rows) override {
    if (!of_tets_) check(rows.rows.triangles);
  }

 private:
  template <class Elements>
  void check(const Elements& elements) {
    for (const auto& element : elements) {
      in_.next_row();
      for (const std::uint32_t v : element) in_.index(v, 0, num_points_);
    }
  }

  Cursor in_;  ///< for its words
  bool of_tets_;
  std::uint64_t num_points_;
};

template <class Out, class Index, std::size_t N>
void write_element(TextOutput<Out>& text, std::int64_t type, const std::array<Index, N>& nodes) {
  text.number(type);
  for (const Index v : nodes) text.number(v);
}

/// `first`: number of the first row in the whole mesh.
template <class Out, class Tets>
void write_tets(TextOutput<Out>& text, const Tets& tets, std::uint64_t first) {
  for (std::size_t i = 0; i < tets.size(); ++i) {
    write_element(text, kTetrahedron, tets[i]);
    text.number(first + i);
    text.end_line();
  }
}

template <class Out>
void write_points(TextOutput<Out>& text, std::span<const Point> points, std::uint64_t first) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int c = 0; c < 3; ++c) text.number(points[i][c]);
    text.number(first + i);
    text.end_line();
  }
}

template <class Out, class Triangles>
void write_triangles(TextOutput<Out>& text, const Triangles& triangles,
                     const std::vector<std::uint32_t>& which) {
  for (const std::uint32_t i : which) {
    write_element(text, kTriangle, triangles[i]);
    text.end_line();
  }
}

/// Tags are single words that begin no comment.
std::string marker_tag(std::string name) {
  for (char& c : name) {
    if (is_space(c) || c == '%' || c == '=') c = '_';
  }
  return name;
}

class Su2Part final : public TextPart {
 public:
  Su2Part(const WholeMesh& whole, const MeshPart& part) : part_(part) {
    std::map<std::int32_t, std::vector<std::uint32_t>> by_ref;
    for (std::uint32_t i = 0; i < part.triangles.refs.size(); ++i)
      by_ref[part.triangles.refs[i]].push_back(i);
    for (const auto& [ref, count] : whole.triangles) of_markers_.push_back(std::move(by_ref[ref]));
  }

  std::string rows(std::size_t section) const override {
    TextInMemory rows;
    TextOutput text(rows);
    if (section == 0) write_tets(text, part_.tets.elements, part_.tets.first);
    if (section == 1) write_points(text, part_.points, part_.first_point);
    if (section >= 2 && section - 2 < of_markers_.size())
      write_triangles(text, part_.triangles.elements, of_markers_[section - 2]);
    return std::move(rows.text);
  }

 private:
  const MeshPart& part_;
  std::vector<std::vector<std::uint32_t>> of_markers_;  ///< the triangles of each
};

MeshContents read_su2_into(const std::filesystem::path& path, MeshStream& stream, Coordinates wanted) {
  const InputFile file(path);
  Cursor in(file);
  in.set_coordinates(wanted);
  MeshContents contents;
  Su2Reader reader(in, contents, stream);
  reader.read();
  for (const bool of_tets : {true, false}) {
    if (reader.greatest_vertex() < reader.num_points()) break;
    Cursor again(file);
    again.set_coordinates(wanted);
    MeshContents none;
    VertexChecker checker(file.name(), of_tets, reader.num_points());
    Su2Reader(again, none, checker).read();
  }
  if (!reader.has_markers()) throw InputError(file.name(), "", "NMARK= is missing");
  return contents;
}

}  // namespace

MeshContents read_su2(const std::filesystem::path& path, Coordinates wanted) {
  MeshCollector collector;
  MeshContents contents = read_su2_into(path, collector, wanted);
  collector.put_into(contents.mesh);
  contents.complete();
  return contents;
}

MeshContents stream_su2(const std::filesystem::path& path, MeshStream& stream) {
  return read_su2_into(path, stream, Coordinates::finite);
}

void write_su2(const std::filesystem::path& path, const MeshView& contents, const WriteOptions&) {
  check_lengths(contents.mesh, contents.fields);
  const MeshData& mesh = contents.mesh;
  const std::vector<std::string> heads = su2_heads(describe(contents));
  AtomicFile out(path);
  TextOutput text(out);
  out.write(heads[0]);
  write_tets(text, mesh.tets, 0);
  out.write(heads[1]);
  write_points(text, mesh.points, 0);
  auto head = heads.begin() + 2;
  for (const auto& [ref, triangles] : indices_by_ref(mesh.triangle_refs)) {
    out.write(*head++);
    write_triangles(text, mesh.triangles, triangles);
  }
  if (head != heads.end()) out.write(*head);
  out.commit();
}

std::vector<std::string> su2_heads(const WholeMesh& whole) {
  std::vector<std::string> heads = {"NDIME= 3\nNELEM= " + std::to_string(whole.num_tets()) + "\n",
                                    "NPOIN= " + std::to_string(whole.points) + "\n"};
  UniqueNames tags;  // readers take equal ones for one marker
  std::string before = "NMARK= " + std::to_string(whole.triangles.size()) + "\n";
  for (const auto& [ref, count] : whole.triangles)
    heads.push_back(std::exchange(before, "") +
                    "MARKER_TAG= " + tags.unique(marker_tag(whole.names.name(2, ref))) +
                    "\nMARKER_ELEMS= " + std::to_string(count) + "\n");
  if (!before.empty()) heads.push_back(before);  // there are no markers
  return heads;
}

std::unique_ptr<TextPart> open_su2_part(const WholeMesh& whole, const MeshPart& part) {
  return std::make_unique<Su2Part>(whole, part);
}

}  // namespace weft::meshing
