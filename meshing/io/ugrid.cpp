// UGRID: seven counts, points, boundary faces, their IDs, volume elements, and optionally IDs of these.
#include "meshing/io/ugrid.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/file_part.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/single_precision.h"
#include "meshing/io/files/text_output.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

struct Encoding {
  bool ascii = false, swapped = false;
  std::uint64_t integer_size = 4, real_size = 8;
};

constexpr Encoding kAscii = {.ascii = true};

struct NamedEncoding {
  std::string_view suffix;
  Encoding encoding;
};
constexpr std::array<NamedEncoding, 6> kEncodings = {{{".lb8", {false, false, 4, 8}},
                                                      {".b8", {false, true, 4, 8}},
                                                      {".lb8l", {false, false, 8, 8}},
                                                      {".b8l", {false, true, 8, 8}},
                                                      {".lb4", {false, false, 4, 4}},
                                                      {".b4", {false, true, 4, 4}}}};

bool is_fortran(std::string_view suffix) {
  return suffix == ".r8" || suffix == ".lr8" || suffix == ".r4" || suffix == ".lr4";
}

Encoding encoding_of(const fs::path& path) {
  const std::string suffix = path.stem().extension().string();
  const auto found = std::ranges::find(kEncodings, suffix, &NamedEncoding::suffix);
  if (found != kEncodings.end()) return found->encoding;
  if (is_fortran(suffix)) {
    throw InputError(path.string(), "", "UGRID files of Fortran records (" + suffix + ") are not known here");
  }
  return kAscii;
}

/// NAME.mapbc for NAME.lb8.ugrid and NAME.ugrid.
fs::path mapbc_beside(const fs::path& path) {
  fs::path beside = path;
  beside.replace_extension();
  if (!encoding_of(path).ascii) beside.replace_extension();
  beside += ".mapbc";
  return beside;
}

struct Counts {
  std::uint64_t points, triangles, quads, tets, pyramids, prisms, hexes;
  std::uint64_t volumes() const { return tets + pyramids + prisms + hexes; }
};

// ---------------------------------------------------------------------------------------------------------
// Reading

/// Optional data that are no volume IDs are refused.
constexpr const char* kUnknownRest =
    "the file is longer than its header says, or has optional data that are not read";

void drop_foreign(const Counts& counts, MeshContents& contents) {
  contents.drop("quadrilaterals", counts.quads);
  contents.drop_volumes("pyramids", counts.pyramids);
  contents.drop_volumes("prisms", counts.prisms);
  contents.drop_volumes("hexahedra", counts.hexes);
}

/// Reads what lies at the cursor; indices are checked against `num_points`.
class UgridReader {
 public:
  UgridReader(Cursor& in, const Encoding& encoding, MeshContents& contents, std::uint64_t num_points = 0)
      : in_(in), encoding_(encoding), mesh_(contents.mesh), contents_(contents), num_points_(num_points) {
    in_.set_swapped(encoding.swapped);
  }

  /// A whole file, into the stream.
  void read(MeshStream& stream) {
    refuse_binary_as_text();
    const Counts counts = read_counts();
    num_points_ = counts.points;
    stream_points(counts.points, stream);
    stream_boundary("triangle", counts.triangles, 3, stream,
                    [this](BoundaryRows& b) { b.rows.triangles.push_back(read_element<3>()); });
    skip_elements("quadrilateral", counts.quads, 4);
    stream_boundary("surface ID", counts.triangles, 1, stream,
                    [this](BoundaryRows& b) { b.rows.triangle_refs.push_back(read_ref()); });
    skip_elements("surface ID of quadrilateral", counts.quads, 1);
    stream_tets(counts.tets, stream);
    skip_elements("pyramid", counts.pyramids, 5);
    skip_elements("prism", counts.prisms, 6);
    skip_elements("hexahedron", counts.hexes, 8);
    drop_foreign(counts, contents_);
    read_volume_ids(counts, stream);
  }

  // Parts of one; `first` is the number of the first row.

  Counts read_counts() {
    in_.enter("header");
    std::array<std::uint64_t, 7> n;
    for (std::uint64_t& count : n) {
      const std::int64_t value = integer();
      if (value < 0) in_.fail("a count is " + std::to_string(value) + ": damaged, or not what its name says");
      count = in_.entity_count(static_cast<std::uint64_t>(value));
    }
    return {n[0], n[1], n[2], n[3], n[4], n[5], n[6]};
  }

  void read_points(std::uint64_t count, std::uint64_t first = 0) {
    in_.enter("node", first);
    in_.require(count, 3 * (encoding_.ascii ? 1 : encoding_.real_size));
    mesh_.points.resize(count);
    for (Point& p : mesh_.points) p = read_point();
  }

  template <std::size_t N>
  void read_elements(const char* name, std::uint64_t count,
                     std::vector<std::array<std::uint32_t, N>>& elements, std::uint64_t first = 0) {
    in_.enter(name, first);
    in_.require(count, N * integer_size());
    elements.resize(count);
    for (auto& element : elements) element = read_element<N>();
  }

  void read_refs(const char* name, std::uint64_t count, std::vector<std::int32_t>& refs,
                 std::uint64_t first = 0) {
    in_.enter(name, first);
    in_.require(count, integer_size());
    refs.resize(count);
    for (std::int32_t& ref : refs) ref = read_ref();
  }

 private:
  Point read_point() {
    in_.next_row();
    Point p;
    for (int c = 0; c < 3; ++c) p[c] = in_.coordinate(real());
    return p;
  }
  template <std::size_t N>
  std::array<std::uint32_t, N> read_element() {
    in_.next_row();
    std::array<std::uint32_t, N> element;
    for (std::uint32_t& v : element) v = in_.index(integer(), 1, num_points_);
    return element;
  }
  std::int32_t read_ref() {
    in_.next_row();
    return in_.ref(integer());
  }

  void stream_points(std::uint64_t count, MeshStream& stream) {
    in_.enter("node");
    in_.require(count, 3 * (encoding_.ascii ? 1 : encoding_.real_size));
    StreamedRows<Point> rows(stream, &MeshStream::take_points);
    for (std::uint64_t i = 0; i < count; ++i) rows.add(read_point());
    rows.pass();
  }
  void stream_tets(std::uint64_t count, MeshStream& stream) {
    in_.enter("tet");
    in_.require(count, 4 * integer_size());
    StreamedRows<std::array<std::uint32_t, 4>> rows(stream, &MeshStream::take_tets);
    for (std::uint64_t i = 0; i < count; ++i) rows.add(read_element<4>());
    rows.pass();
  }
  /// `read` adds a row of so many integers.
  template <class Read>
  void stream_boundary(const char* name, std::uint64_t count, std::uint64_t integers, MeshStream& stream,
                       Read read) {
    in_.enter(name);
    in_.require(count, integers * integer_size());
    StreamedBoundary boundary(stream);
    for (std::uint64_t i = 0; i < count; ++i) {
      read(boundary.rows);
      boundary.pass_if_full();
    }
    boundary.pass();
  }
  void stream_volume_ids(std::uint64_t count, MeshStream& stream) {
    in_.enter("volume ID");
    in_.require(count, integer_size());
    StreamedRows<std::int32_t> rows(stream, &MeshStream::take_tet_refs);
    for (std::uint64_t i = 0; i < count; ++i) rows.add(read_ref());
    rows.pass();
  }

  /// Some programs (CGNS' cgns_to_aflr3) give binary files the name of text; their seven counts have zero
  /// bytes.
  void refuse_binary_as_text() {
    if (encoding_.ascii && in_.ahead(28).find('\0') != std::string_view::npos)
      in_.fail("is binary: call it .b8.ugrid, or .lb8.ugrid if its bytes are little-endian");
  }

  std::int64_t integer() {
    if (encoding_.ascii) return in_.text_integer();
    return encoding_.integer_size == 8 ? in_.value<std::int64_t>() : in_.value<std::int32_t>();
  }
  double real() {
    if (encoding_.ascii) return in_.text_real();
    return encoding_.real_size == 8 ? in_.value<double>() : in_.value<float>();
  }
  /// The least bytes that a number can take; in text a digit.
  std::uint64_t integer_size() const { return encoding_.ascii ? 1 : encoding_.integer_size; }

  void skip_elements(const char* name, std::uint64_t count, std::uint64_t nodes) {
    in_.enter(name);
    in_.require(count, nodes * integer_size());
    if (!encoding_.ascii) return in_.seek(in_.position() + count * nodes * integer_size());
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      for (std::uint64_t n = 0; n < nodes; ++n) integer();
    }
  }

  /// What may follow: the number of tets in boundary layers, and an ID for every volume element.
  void read_volume_ids(const Counts& counts, MeshStream& stream) {
    in_.enter("");
    if (encoding_.ascii) in_.skip_blanks();
    if (in_.at_end()) return;
    const bool fits = encoding_.ascii || in_.remaining() == (1 + counts.volumes()) * integer_size();
    if (!fits || counts.volumes() == 0) {
      in_.fail(kUnknownRest);
    }
    in_.enter("header of volume IDs");
    integer();
    stream_volume_ids(counts.tets, stream);
    skip_elements("volume ID", counts.volumes() - counts.tets, 1);
    in_.enter("");
    if (encoding_.ascii) in_.skip_blanks();
    if (!in_.at_end()) in_.fail("there is more in the file than its header says");
  }

  Cursor& in_;
  const Encoding encoding_;
  MeshData& mesh_;
  MeshContents& contents_;
  std::uint64_t num_points_;
};

/// A binary file of which ranges are read: its sections have known places.
class RangeReader {
 public:
  explicit RangeReader(const fs::path& path) : file_(path), encoding_(encoding_of(path)) {
    const std::uint64_t integer = encoding_.integer_size;
    if (file_.size() < 7 * integer) throw InputError(file_.name(), "header", "the file is truncated");
    MeshContents none;
    at(0, 7, integer, none, [this](UgridReader& in) { counts_ = in.read_counts(); });
    points_ = 7 * integer;
    triangles_ = points_ + 3 * counts_.points * encoding_.real_size;
    triangle_ids_ = triangles_ + (3 * counts_.triangles + 4 * counts_.quads) * integer;
    tets_ = triangle_ids_ + (counts_.triangles + counts_.quads) * integer;
    const std::uint64_t nodes =
        4 * counts_.tets + 5 * counts_.pyramids + 6 * counts_.prisms + 8 * counts_.hexes;
    find_volume_ids(tets_ + nodes * integer);
  }

  MeshSize size() const { return {counts_.points, counts_.tets}; }

  void read(const MeshRange& range, MeshContents& out) const {
    const std::uint64_t integer = encoding_.integer_size, real = 3 * encoding_.real_size;
    at(points_ + range.first_point * real, range.num_points, real, out,
       [&](UgridReader& in) { in.read_points(range.num_points, range.first_point); });
    const std::uint64_t first = range.part_begin(counts_.triangles);
    const std::uint64_t count = range.part_end(counts_.triangles) - first;
    at(triangles_ + first * 3 * integer, count, 3 * integer, out,
       [&](UgridReader& in) { in.read_elements("triangle", count, out.mesh.triangles, first); });
    at(triangle_ids_ + first * integer, count, integer, out,
       [&](UgridReader& in) { in.read_refs("surface ID", count, out.mesh.triangle_refs, first); });
    at(tets_ + range.first_tet * 4 * integer, range.num_tets, 4 * integer, out,
       [&](UgridReader& in) { in.read_elements("tet", range.num_tets, out.mesh.tets, range.first_tet); });
    if (volume_ids_ > 0)
      at(volume_ids_ + range.first_tet * integer, range.num_tets, integer, out, [&](UgridReader& in) {
        in.read_refs("volume ID", range.num_tets, out.mesh.tet_refs, range.first_tet);
      });
    drop_foreign(counts_, out);
  }

 private:
  /// `end`: of the elements.
  void find_volume_ids(std::uint64_t end) {
    const std::uint64_t integer = encoding_.integer_size;
    if (file_.size() < end)
      throw InputError(file_.name(), "header",
                       "the file is truncated, or a count is wrong: it has " + std::to_string(file_.size()) +
                           " bytes of " + std::to_string(end));
    if (file_.size() == end) return;
    if (counts_.volumes() == 0 || file_.size() != end + (1 + counts_.volumes()) * integer)
      throw InputError(file_.name(), "", kUnknownRest);
    volume_ids_ = end + integer;
  }

  template <class Read>
  void at(std::uint64_t position, std::uint64_t rows, std::uint64_t row_size, MeshContents& out,
          const Read& read) const {
    std::vector<char> bytes(rows * row_size);
    file_.read_at(position, bytes.data(), bytes.size());
    Cursor in(file_.name(), {bytes.data(), bytes.size()});
    UgridReader reader(in, encoding_, out, counts_.points);
    read(reader);
  }

  InputFile file_;
  Encoding encoding_;
  Counts counts_{};
  std::uint64_t points_ = 0, triangles_ = 0, triangle_ids_ = 0, tets_ = 0;
  std::uint64_t volume_ids_ = 0;  ///< 0: the file has none
};

std::string conditions_of(const fs::path& mapbc) {
  return "boundary conditions of " + mapbc.filename().string();
}

/// A .mapbc: the number of lines, then lines of surface ID, boundary condition, name. Conditions are dropped.
void read_mapbc(const fs::path& path, MeshContents& contents) {
  const FileBytes file(path);
  Cursor in(file.name(), file.bytes());
  in.enter("header");
  const std::uint64_t count = in.text_count();
  in.line();
  in.enter("boundary");
  for (std::uint64_t i = 0; i < count; ++i) {
    in.next_row();
    const std::int32_t ref = in.ref(in.text_integer());
    in.text_integer();
    const std::string_view name = trimmed(in.line());
    if (!name.empty()) contents.names.set(2, ref, std::string(name));
    contents.drop(conditions_of(path));
  }
}

// ---------------------------------------------------------------------------------------------------------
// Writing

/// `most`: of the counts.
void check_integers(const std::string& name, const Encoding& encoding, std::uint64_t most) {
  if (encoding.integer_size == 4 && !std::in_range<std::int32_t>(most))
    throw InputError(name, "", "too large for the 32-bit integers of this UGRID encoding: use .lb8l.ugrid");
}

template <class File, class T>
void write_value(File& file, const Encoding& encoding, T value) {
  file.write_value(encoding.swapped ? byte_swapped(value) : value);
}

/// Rows in any encoding, into whatever has write() and write_value().
template <class File>
class UgridRows {
 public:
  UgridRows(File& file, const Encoding& encoding) : file_(file), text_(file), encoding_(encoding) {}

  void counts(std::uint64_t points, std::uint64_t triangles, std::uint64_t tets) {
    for (const std::uint64_t count : {points, triangles, std::uint64_t{0}, tets}) integer(count);
    for (int other = 0; other < 3; ++other) integer(0);
    end_row();
  }
  void points(std::span<const Point> points) {
    for (const Point& p : points) {
      for (int c = 0; c < 3; ++c) real(p[c]);
      end_row();
    }
  }
  template <class Elements>
  void elements(const Elements& elements) {
    for (const auto& element : elements) {
      for (const std::uint64_t v : element) integer(v + 1);
      end_row();
    }
  }
  void refs(std::span<const std::int32_t> refs) {
    for (const std::int32_t ref : refs) {
      integer(ref);
      end_row();
    }
  }
  void no_boundary_layers() {
    integer(0);
    end_row();
  }

 private:
  template <class Integer>
  void integer(Integer number) {
    if (encoding_.ascii) return text_.number(number);
    encoding_.integer_size == 8 ? write_value(file_, encoding_, static_cast<std::int64_t>(number))
                                : write_value(file_, encoding_, static_cast<std::int32_t>(number));
  }
  void real(double number) {
    if (encoding_.ascii) return text_.number(number);
    encoding_.real_size == 8 ? write_value(file_, encoding_, number)
                             : write_value(file_, encoding_, static_cast<float>(number));
  }
  void end_row() {
    if (encoding_.ascii) text_.end_line();
  }

  File& file_;
  TextOutput<File> text_;
  Encoding encoding_;
};

MeshContents read_ugrid_into(const fs::path& path, MeshStream& stream, Coordinates wanted) {
  const Encoding encoding = encoding_of(path);
  const InputFile file(path);
  Cursor in(file);
  in.set_coordinates(wanted);
  MeshContents contents;
  UgridReader(in, encoding, contents).read(stream);
  if (fs::exists(mapbc_beside(path))) read_mapbc(mapbc_beside(path), contents);
  return contents;
}

}  // namespace

MeshContents read_ugrid(const fs::path& path, Coordinates wanted) {
  MeshCollector collector;
  MeshContents contents = read_ugrid_into(path, collector, wanted);
  collector.put_into(contents.mesh);
  contents.complete();
  return contents;
}

MeshContents stream_ugrid(const fs::path& path, MeshStream& stream) {
  return read_ugrid_into(path, stream, Coordinates::finite);
}

bool is_ascii_ugrid(const fs::path& path) { return encoding_of(path).ascii; }

std::optional<MeshSize> ugrid_size(const fs::path& path) {
  if (encoding_of(path).ascii) return std::nullopt;
  return RangeReader(path).size();
}

MeshContents read_ugrid_range(const fs::path& path, const MeshRange& range) {
  MeshContents contents;
  RangeReader(path).read(range, contents);
  contents.complete();
  if (fs::exists(mapbc_beside(path))) read_mapbc(mapbc_beside(path), contents);
  return contents;
}

void write_ugrid(const fs::path& path, const MeshView& contents, const WriteOptions&) {
  check_lengths(contents.mesh, contents.fields);
  const Encoding encoding = encoding_of(path);
  const MeshData& mesh = contents.mesh;
  if (has_ugrid_short_reals(path)) refuse_if_rounding_breaks(mesh, path.string());
  check_integers(path.string(), encoding,
                 std::max({mesh.points.size(), mesh.triangles.size(), mesh.tets.size()}));
  AtomicFile file(path);
  UgridRows rows(file, encoding);
  rows.counts(mesh.points.size(), mesh.triangles.size(), mesh.tets.size());
  rows.points(mesh.points);
  rows.elements(mesh.triangles);
  rows.refs(mesh.triangle_refs);
  rows.elements(mesh.tets);
  if (std::ranges::any_of(mesh.tet_refs, [](std::int32_t ref) { return ref != 0; })) {
    rows.no_boundary_layers();
    rows.refs(mesh.tet_refs);
  }
  file.commit();
}

bool is_binary_ugrid(const fs::path& path) { return !encoding_of(path).ascii; }

bool has_ugrid_short_reals(const fs::path& path) {
  const Encoding encoding = encoding_of(path);
  return !encoding.ascii && encoding.real_size == 4;
}

namespace {

/// Volume IDs are written where there are any.
bool has_tet_refs(const WholeMesh& whole) {
  return std::ranges::any_of(whole.tets, [](const auto& of_ref) { return of_ref.first != 0; });
}

/// Rows of one part, at their places.
class UgridPartWriter final : public PartWriter {
 public:
  UgridPartWriter(PartTarget target, const WholeMesh& whole)
      : encoding_(encoding_of(target.name)),
        file_(std::move(target)),
        rows_(file_, encoding_),
        has_tet_refs_(has_tet_refs(whole)) {
    const std::uint64_t integer = encoding_.integer_size;
    points_ = 7 * integer;
    triangles_ = points_ + 3 * whole.points * encoding_.real_size;
    surface_ids_ = triangles_ + 3 * whole.num_triangles() * integer;
    tets_ = surface_ids_ + whole.num_triangles() * integer;
    boundary_layers_ = tets_ + 4 * whole.num_tets() * integer;
  }

  /// All that is no row.
  void write_frame(const WholeMesh& whole) {
    file_.seek(0);
    rows_.counts(whole.points, whole.num_triangles(), whole.num_tets());
    if (!has_tet_refs_) return;
    file_.seek(boundary_layers_);
    rows_.no_boundary_layers();
  }

  void write(const MeshPart& part) override {
    file_.seek(points_ + 3 * part.first_point * encoding_.real_size);
    rows_.points(part.points);
    write_elements(triangles_, part.triangles);
    write_refs(surface_ids_, part.triangles.first, part.triangles.refs);
    write_elements(tets_, part.tets);
    if (has_tet_refs_) write_refs(boundary_layers_ + encoding_.integer_size, part.tets.first, part.tets.refs);
  }
  void finish() override { file_.finish(); }

 private:
  template <std::size_t N>
  void write_elements(std::uint64_t begin, const ElementRows<N>& rows) {
    file_.seek(begin + rows.first * N * encoding_.integer_size);
    rows_.elements(rows.elements);
  }
  void write_refs(std::uint64_t begin, std::uint64_t first, std::span<const std::int32_t> refs) {
    file_.seek(begin + first * encoding_.integer_size);
    rows_.refs(refs);
  }

  Encoding encoding_;
  FilePart file_;
  UgridRows<FilePart> rows_;
  bool has_tet_refs_;
  // Where these begin; volume IDs follow the number of tets in boundary layers.
  std::uint64_t points_ = 0, triangles_ = 0, surface_ids_ = 0, tets_ = 0, boundary_layers_ = 0;
};

}  // namespace

PartPlaces begin_ugrid_parts(const fs::path& file, const fs::path& name, const WholeMesh& whole) {
  check_integers(name.string(), encoding_of(name),
                 std::max({whole.points, whole.num_triangles(), whole.num_tets()}));
  UgridPartWriter writer({file, name.string()}, whole);
  writer.write_frame(whole);
  writer.finish();
  return {};
}

std::unique_ptr<PartWriter> open_ugrid_part(PartTarget target, const WholeMesh& whole, const PartPlaces&) {
  return std::make_unique<UgridPartWriter>(std::move(target), whole);
}

std::vector<std::string> ugrid_heads(const WholeMesh& whole) {
  std::vector<std::string> heads(4);  // points, triangles, their surface IDs, tets
  TextInMemory counts;
  UgridRows(counts, kAscii).counts(whole.points, whole.num_triangles(), whole.num_tets());
  heads[0] = std::move(counts.text);
  if (has_tet_refs(whole)) heads.push_back("0\n");  // tets in boundary layers; volume IDs follow
  return heads;
}

namespace {

class UgridTextPart final : public TextPart {
 public:
  explicit UgridTextPart(const MeshPart& part) : part_(part) {}

  std::string rows(std::size_t section) const override {
    TextInMemory text;
    UgridRows rows(text, kAscii);
    if (section == 0) rows.points(part_.points);
    if (section == 1) rows.elements(part_.triangles.elements);
    if (section == 2) rows.refs(part_.triangles.refs);
    if (section == 3) rows.elements(part_.tets.elements);
    if (section == 4) rows.refs(part_.tets.refs);
    return std::move(text.text);
  }

 private:
  const MeshPart& part_;
};

}  // namespace

std::unique_ptr<TextPart> open_ugrid_text_part(const WholeMesh&, const MeshPart& part) {
  return std::make_unique<UgridTextPart>(part);
}

bool has_mapbc_for(const fs::path& from, const fs::path& to) {
  if (from.extension() != ".ugrid" || to.extension() != ".ugrid") return false;
  const auto bytes_of = [](const fs::path& mesh) {
    std::ifstream file(mapbc_beside(mesh), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  return fs::exists(mapbc_beside(from)) && (!fs::exists(mapbc_beside(to)) || bytes_of(from) == bytes_of(to));
}

void leave_to_mapbc(const fs::path& from, RefNames& names, std::vector<Dropped>& dropped) {
  names = {};
  std::erase_if(dropped, [&](const Dropped& d) { return d.what == conditions_of(mapbc_beside(from)); });
}

void copy_mapbc(const fs::path& from, const fs::path& to) {
  const fs::path target = mapbc_beside(to);
  if (!has_mapbc_for(from, to) || fs::exists(target)) return;
  const FileBytes bytes(mapbc_beside(from));
  AtomicFile file(target);
  file.write(bytes.bytes());
  file.commit();
}

}  // namespace weft::meshing
