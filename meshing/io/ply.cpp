// PLY: a text header that declares elements with properties, then their rows as text or bytes.
#include "meshing/io/ply.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/text_output.h"
#include "meshing/mesh/polygon.h"

namespace weft::meshing {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct TypeInfo {
  std::string_view name, other_name;
  std::uint64_t size;
};
constexpr std::array<TypeInfo, 8> kTypes = {{{"char", "int8", 1},
                                             {"uchar", "uint8", 1},
                                             {"short", "int16", 2},
                                             {"ushort", "uint16", 2},
                                             {"int", "int32", 4},
                                             {"uint", "uint32", 4},
                                             {"float", "float32", 4},
                                             {"double", "float64", 8}}};

bool is_real(Type type) { return type == Type::float32 || type == Type::float64; }

std::optional<Type> find_type(std::string_view name) {
  for (std::size_t i = 0; i < kTypes.size(); ++i) {
    if (name == kTypes[i].name || name == kTypes[i].other_name) return static_cast<Type>(i);
  }
  return std::nullopt;
}

/// What becomes of a property's value.
enum class Role { dropped, x, y, z, ref, field, corners, vertex1, vertex2 };

struct Property {
  std::string name;
  Type type = Type::float32;
  std::optional<Type> count_type = {};  ///< of a list
  Role role = Role::dropped;
  std::size_t field = 0;  ///< index, of a Role::field
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties = {};
};

struct Header {
  enum class Encoding { ascii, little_endian, big_endian };
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
};

std::optional<Header::Encoding> find_encoding(std::string_view name) {
  if (name == "ascii") return Header::Encoding::ascii;
  if (name == "binary_little_endian") return Header::Encoding::little_endian;
  if (name == "binary_big_endian") return Header::Encoding::big_endian;
  return std::nullopt;
}

Type read_type(Cursor& line) {
  const std::string_view word = line.word();
  const auto type = find_type(word);
  if (!type) line.fail("unknown type " + quoted(word));
  return *type;
}

Property read_property(Cursor& line) {
  Property property;
  const std::size_t begin = line.position();
  if (line.word() == "list") {
    property.count_type = read_type(line);
    if (is_real(*property.count_type)) line.fail("a list's count must be an integer");
  } else {
    line.seek(begin);
  }
  property.type = read_type(line);
  property.name = line.word();
  return property;
}

/// Reads the lines up to end_header; the cursor is left where the rows begin.
Header read_header(Cursor& in) {
  if (trimmed(in.line()) != "ply")
    throw InputError(in.file(), "", "not a PLY file: it does not begin with ply");
  Header header;
  bool has_format = false;
  for (;;) {
    if (in.at_end()) throw InputError(in.file(), "header", "the file is truncated: no end_header");
    Cursor line(in.file(), in.line());
    line.enter("header");
    const std::string_view key = line.word();
    if (key == "end_header") break;
    if (key == "format") {
      const std::string_view word = line.word();
      const auto encoding = find_encoding(word);
      if (!encoding) line.fail("unknown format " + quoted(word));
      header.encoding = *encoding;
      has_format = true;
    } else if (key == "element") {
      Element element{std::string(line.word())};
      element.count = line.entity_count(line.text_count());
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) line.fail("a property before the first element");
      header.elements.back().properties.push_back(read_property(line));
    } else if (!key.empty() && key != "comment" && key != "obj_info") {
      line.fail("unknown line " + quoted(key));
    }
  }
  if (!has_format) throw InputError(in.file(), "header", "has no format");
  return header;
}

/// Reads the rows of the elements, of either encoding.
class Body {
 public:
  Body(Cursor& in, Header header, MeshContents& contents)
      : in_(in), header_(std::move(header)), contents_(contents) {
    in_.set_swapped(header_.encoding == Header::Encoding::big_endian);
  }

  void read() {
    for (const Element& element : header_.elements) {
      if (element.name == "vertex") num_points_ = element.count;
    }
    for (Element& element : header_.elements) read_element(element);
    // In text, numbers behind the last row mean that a count is wrong.
    in_.enter("");
    if (ascii() && !in_.word().empty()) in_.fail("there is more in the file than the header's counts say");
    if (!ascii() && !in_.at_end()) in_.fail("there is more in the file than the header's counts say");
    polygons_.unfold(contents_.mesh);
  }

 private:
  bool ascii() const { return header_.encoding == Header::Encoding::ascii; }

  void read_element(Element& element) {
    in_.enter(element.name);
    if (element.properties.empty()) in_.fail("has no properties");
    in_.require(element.count, least_row_size(element));
    if (element.name == "vertex") return read_vertices(element);
    if (element.name == "face") return read_faces(element);
    if (element.name == "edge") return read_edges(element);
    contents_.drop("elements " + element.name, element.count);
    if (element.name.starts_with("tet") || element.name.starts_with("cell")) {
      contents_.foreign_volumes += element.count;
    }
    read_rows(element, [] {});
  }

  std::uint64_t least_row_size(const Element& element) const {
    std::uint64_t size = 0;
    for (const Property& p : element.properties) {
      const Type first = p.count_type.value_or(p.type);
      size += ascii() ? 1 : kTypes[static_cast<std::size_t>(first)].size;
    }
    return size;
  }

  /// Reads every row into the members below and calls row() after each.
  template <class Row>
  void read_rows(const Element& element, Row row) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      in_.next_row();
      for (const Property& property : element.properties) {
        if (property.count_type) {
          read_list(property);
        } else {
          store(property, number(property.type));
        }
      }
      row();
    }
  }

  double number(Type type) {
    if (ascii()) return in_.text_real();
    switch (type) {
      case Type::int8:
        return in_.value<std::int8_t>();
      case Type::uint8:
        return in_.value<std::uint8_t>();
      case Type::int16:
        return in_.value<std::int16_t>();
      case Type::uint16:
        return in_.value<std::uint16_t>();
      case Type::int32:
        return in_.value<std::int32_t>();
      case Type::uint32:
        return in_.value<std::uint32_t>();
      case Type::float32:
        return in_.value<float>();
      case Type::float64:
        return in_.value<double>();
    }
    in_.fail("unknown type");
  }

  std::int64_t integer(double value) const {
    if (!(std::abs(value) <= 0xFFFFFFFFu) || value != std::floor(value)) {
      in_.fail("expected an integer of 32 bits, found " + std::to_string(value));
    }
    return static_cast<std::int64_t>(value);
  }

  void read_list(const Property& property) {
    const std::int64_t count = integer(number(*property.count_type));
    if (count < 0) in_.fail("a list's count is negative");
    in_.require(static_cast<std::uint64_t>(count),
                ascii() ? 1 : kTypes[static_cast<std::size_t>(property.type)].size);
    const bool kept = property.role == Role::corners;
    if (kept) corners_.clear();
    for (std::int64_t i = 0; i < count; ++i) {
      const double value = number(property.type);
      if (kept) corners_.push_back(in_.index(integer(value), 0, num_points_));
    }
  }

  void store(const Property& property, double value) {
    switch (property.role) {
      case Role::x:
      case Role::y:
      case Role::z:
        point_[static_cast<int>(property.role) - static_cast<int>(Role::x)] = in_.coordinate(value);
        break;
      case Role::ref:
        ref_ = in_.ref(integer(value));
        break;
      case Role::field:
        contents_.fields.fields[property.field].values.push_back(value);
        break;
      case Role::vertex1:
      case Role::vertex2:
        edge_[property.role == Role::vertex2] = in_.index(integer(value), 0, num_points_);
        break;
      case Role::corners:
      case Role::dropped:
        break;
    }
  }

  /// Gives the property called `name` its role; what it was declared as must fit.
  bool assign(Element& element, std::string_view name, Role role, bool list = false) {
    for (Property& p : element.properties) {
      if (p.name != name || p.count_type.has_value() != list) continue;
      if (p.role != Role::dropped) in_.fail("property " + std::string(name) + " appears twice");
      p.role = role;
      return true;
    }
    return false;
  }

  void drop_the_rest(const Element& element) {
    for (const Property& p : element.properties) {
      if (p.role == Role::dropped) contents_.drop("values of property " + p.name, element.count);
    }
  }

  void read_vertices(Element& element) {
    if (!contents_.mesh.points.empty()) in_.fail("appears twice");
    if (!assign(element, "x", Role::x) || !assign(element, "y", Role::y) || !assign(element, "z", Role::z)) {
      in_.fail("has no properties x, y and z");
    }
    assign(element, "ref", Role::ref);
    for (Property& p : element.properties) {
      const bool normal = p.name == "nx" || p.name == "ny" || p.name == "nz";
      if (p.role != Role::dropped || p.count_type || !is_real(p.type) || normal) continue;
      p.role = Role::field;
      p.field = contents_.fields.fields.size();
      contents_.fields.fields.push_back({Field::Kind::scalar, {}, p.name});
    }
    drop_the_rest(element);
    contents_.mesh.points.reserve(element.count);
    contents_.mesh.point_refs.reserve(element.count);
    read_rows(element, [this] {
      contents_.mesh.points.push_back(point_);
      contents_.mesh.point_refs.push_back(ref_);
    });
    ref_ = 0;
  }

  void read_faces(Element& element) {
    if (!assign(element, "vertex_indices", Role::corners, true) &&
        !assign(element, "vertex_index", Role::corners, true)) {
      in_.fail("has no list vertex_indices");
    }
    assign(element, "ref", Role::ref);
    drop_the_rest(element);
    contents_.mesh.triangles.reserve(element.count);
    contents_.mesh.triangle_refs.reserve(element.count);
    read_rows(element, [this] { add_polygon(); });
    ref_ = 0;
  }

  void add_polygon() {
    if (corners_.size() < 3) in_.fail("has fewer than three corners");
    if (corners_.size() > 3) contents_.drop("polygons (cut into triangles)");
    polygons_.add(corners_, ref_, contents_.mesh);
  }

  void read_edges(Element& element) {
    if (!assign(element, "vertex1", Role::vertex1) || !assign(element, "vertex2", Role::vertex2)) {
      in_.fail("has no properties vertex1 and vertex2");
    }
    assign(element, "ref", Role::ref);
    drop_the_rest(element);
    read_rows(element, [this] {
      contents_.mesh.edges.push_back(edge_);
      contents_.mesh.edge_refs.push_back(ref_);
    });
    ref_ = 0;
  }

  Cursor& in_;
  Header header_;
  MeshContents& contents_;
  std::uint64_t num_points_ = 0;
  // The row being read:
  Point point_;
  std::int32_t ref_ = 0;
  std::vector<std::uint32_t> corners_;
  Polygons polygons_;
  std::array<std::uint32_t, 2> edge_{};
};

/// Writes rows of any encoding.
class PlyWriter {
 public:
  PlyWriter(const std::filesystem::path& path, WriteOptions::Encoding encoding)
      : file_(path), text_(file_), encoding_(encoding) {}

  void write(const MeshContents& surface) {
    write_header(surface);
    write_vertices(surface);
    const MeshData& mesh = surface.mesh;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      value<std::uint8_t>(3);
      for (const std::uint32_t v : mesh.triangles[i]) value(static_cast<std::int32_t>(v));
      value(mesh.triangle_refs[i]);
      end_row();
    }
    for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
      for (const std::uint32_t v : mesh.edges[i]) value(static_cast<std::int32_t>(v));
      value(mesh.edge_refs[i]);
      end_row();
    }
    file_.commit();
  }

 private:
  bool ascii() const { return encoding_ == WriteOptions::Encoding::ascii; }

  template <class T>
  void value(T value) {
    if (ascii()) return text_.number(value);
    file_.write_value(encoding_ == WriteOptions::Encoding::big_endian ? byte_swapped(value) : value);
  }
  void end_row() {
    if (ascii()) text_.end_line();
  }

  void write_header(const MeshContents& surface) {
    const MeshData& mesh = surface.mesh;
    text_.line("ply");
    text_.line(ascii()                                           ? "format ascii 1.0"
               : encoding_ == WriteOptions::Encoding::big_endian ? "format binary_big_endian 1.0"
                                                                 : "format binary_little_endian 1.0");
    text_.line("comment written by weft");
    text_.line("element vertex " + std::to_string(mesh.points.size()));
    text_.line("property double x\nproperty double y\nproperty double z\nproperty int ref");
    for (std::size_t i = 0; i < surface.fields.fields.size(); ++i) {
      if (surface.fields.fields[i].kind != Field::Kind::scalar) continue;
      text_.line("property double " + property_name(field_name(surface.fields, i)));
    }
    text_.line("element face " + std::to_string(mesh.triangles.size()));
    text_.line("property list uchar int vertex_indices\nproperty int ref");
    if (!mesh.edges.empty()) {
      text_.line("element edge " + std::to_string(mesh.edges.size()));
      text_.line("property int vertex1\nproperty int vertex2\nproperty int ref");
    }
    text_.line("end_header");
  }

  /// Names of properties are single words, and some have a meaning.
  static std::string property_name(std::string name) {
    for (char& c : name) {
      if (is_space(c)) c = '_';
    }
    for (const std::string_view taken : {"x", "y", "z", "ref", "nx", "ny", "nz"}) {
      if (name == taken) return "field_" + name;
    }
    return name;
  }

  void write_vertices(const MeshContents& surface) {
    const MeshData& mesh = surface.mesh;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      for (int c = 0; c < 3; ++c) value(mesh.points[i][c]);
      value(mesh.point_refs[i]);
      for (const Field& field : surface.fields.fields) {
        if (field.kind == Field::Kind::scalar) value(field.values[i]);
      }
      end_row();
    }
  }

  AtomicFile file_;
  TextOutput<> text_;
  WriteOptions::Encoding encoding_;
};

}  // namespace

MeshContents read_ply(const std::filesystem::path& path) {
  const FileBytes file(path);
  Cursor in(file.name(), file.bytes());
  MeshContents contents;
  Header header = read_header(in);
  Body(in, std::move(header), contents).read();
  contents.complete();
  return contents;
}

void write_ply(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options) {
  check_lengths(contents.mesh, contents.fields);
  PlyWriter(path, options.encoding).write(surface_of(contents));
}

}  // namespace weft::meshing
