// Sections of MSH files around the rows, and the rows: written in their order, or by many at their places.
#include "meshing/io/gmsh/gmsh_writer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/file_part.h"
#include "meshing/io/files/text_output.h"
#include "meshing/io/gmsh/gmsh_codes.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

/// Lines and numbers in the encoding of a file.
template <class Out>
class MshOutput {
 public:
  MshOutput(Out& out, const WriteOptions& options)
      : out_(out),
        text_(out),
        version_(options.gmsh_version),
        binary_(options.encoding != WriteOptions::Encoding::ascii) {}

  Out& out() { return out_; }
  int version() const { return version_; }
  bool is_binary() const { return binary_; }
  void line(std::string_view text) { text_.line(text); }
  void integer(std::int32_t value) { binary_ ? out_.write_value(value) : text_.number(value); }
  void size(std::uint64_t value) {
    if (!binary_) return text_.number(value);
    version_ == 4 ? out_.write_value(value) : out_.write_value(static_cast<std::int32_t>(value));
  }
  void real(double value) { binary_ ? out_.write_value(value) : text_.number(value); }
  void point(const Point& p) {
    for (int c = 0; c < 3; ++c) real(p[c]);
  }
  void end_row() {
    if (!binary_) text_.end_line();
  }
  /// The line feed that ends a binary section.
  void end_section(std::string_view end) {
    if (binary_) out_.write("\n");
    text_.line(end);
  }

 private:
  Out& out_;
  TextOutput<Out> text_;
  int version_;
  bool binary_;
};

std::string quoted_name(std::string name) {
  std::ranges::replace(name, '"', '\'');
  return '"' + name + '"';
}

/// By dimension: the tag of the geometric entity, which must be above zero, of every reference.
using EntityTags = std::array<std::map<std::int32_t, std::int32_t>, 4>;

std::map<std::int32_t, std::int32_t> entity_tags(const RefCounts& refs) {
  std::map<std::int32_t, std::int32_t> tags;
  for (const auto& [ref, count] : refs) tags[ref] = ref;
  std::int32_t free = 1;
  for (auto& [ref, tag] : tags) {
    if (ref > 0) continue;
    while (tags.contains(free)) ++free;
    tag = free++;
  }
  return tags;
}
EntityTags entity_tags(const WholeMesh& whole) {
  return {std::map<std::int32_t, std::int32_t>{}, entity_tags(whole.edges), entity_tags(whole.triangles),
          entity_tags(whole.tets)};
}

std::uint64_t num_elements(const WholeMesh& whole) {
  return whole.corners.size() + whole.num_edges() + whole.num_triangles() + whole.num_tets();
}

std::size_t row_length(const Field& field) {
  return field.kind == Field::Kind::tensor ? 9 : static_cast<std::size_t>(components(field.kind));
}

/// The values at a point as Gmsh has them: full tensors.
template <class Out>
void write_values(MshOutput<Out>& out, const Field& field, std::size_t point) {
  const auto length = static_cast<std::size_t>(components(field.kind));
  const double* values = field.values.data() + point * length;
  if (field.kind == Field::Kind::tensor) {
    for (const int place : kFullTensorPlaces) out.real(values[place]);
  } else {
    for (std::size_t c = 0; c < length; ++c) out.real(values[c]);
  }
}

template <class Out>
void write_format(MshOutput<Out>& out) {
  out.line("$MeshFormat");
  out.line(std::string(out.version() == 4 ? "4.1" : "2.2") + (out.is_binary() ? " 1 8" : " 0 8"));
  if (out.is_binary()) {
    out.out().write_value(std::int32_t{1});
    out.out().write("\n");
  }
  out.line("$EndMeshFormat");
}

template <class Out>
void write_names(MshOutput<Out>& out, const RefNames& names) {
  if (names.empty()) return;
  out.line("$PhysicalNames");
  out.line(std::to_string(names.all().size()));
  for (const auto& [key, unused] : names.all())
    out.line(std::to_string(key.dimension) + " " + std::to_string(key.ref) + " " +
             quoted_name(names.name(key.dimension, key.ref)));
  out.line("$EndPhysicalNames");
}

/// Of version 4.1.
template <class Out, std::size_t N, class Index>
void write_element4(MshOutput<Out>& out, std::uint64_t number, const std::array<Index, N>& nodes) {
  out.size(number);
  for (const Index node : nodes) out.size(std::uint64_t{node} + 1);
  out.end_row();
}

/// Of version 2.2.
template <class Out, std::size_t N, class Index>
void write_element2(MshOutput<Out>& out, std::uint64_t number, std::int32_t ref, std::int32_t tag,
                    const std::array<Index, N>& nodes) {
  constexpr std::array<std::int32_t, 5> kTypes = {0, gmsh::kPoint, gmsh::kLine, gmsh::kTriangle,
                                                  gmsh::kTetrahedron};
  out.size(number);
  if (!out.is_binary()) {
    out.integer(kTypes[N]);
    out.integer(2);  // tags
  }
  out.integer(ref);
  out.integer(tag);
  for (const Index node : nodes) out.size(std::uint64_t{node} + 1);
  out.end_row();
}

/// Rows that follow one another in a file.
struct Section {
  enum class Kind { node_tags, points, nodes, elements, field };
  Kind kind;
  std::size_t index = 0;                     ///< vertices of the elements, or the field
  std::optional<std::int32_t> ref = {};      ///< of all the elements (4.1), which have those of any (2.2)
  std::uint64_t number = 0;                  ///< of the first element
  std::uint64_t position = 0, row_size = 0;  ///< in a binary file
};

/// Node data; rows(section) writes the rows of one, or leaves room for them.
template <class Out, class Rows>
void write_fields(MshOutput<Out>& out, const std::string& name, const WholeMesh& whole, Rows& rows) {
  const auto& fields = whole.fields.fields;
  if (!fields.empty() && whole.points > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
    throw InputError(name, "", "too many nodes for MSH node data");
  for (std::size_t i = 0; i < fields.size(); ++i) {
    out.line("$NodeData\n1\n" + quoted_name(field_name(whole.fields, i)) + "\n1\n0\n3\n0");
    out.line(std::to_string(row_length(fields[i])) + "\n" + std::to_string(whole.points));
    rows({Section::Kind::field, i});
    out.end_section("$EndNodeData");
  }
}

/// A file of version 4.1; `rows` as in write_fields().
template <class Out, class Rows>
class File4 {
 public:
  File4(MshOutput<Out>& out, const WholeMesh& whole, Rows& rows)
      : out_(out), whole_(whole), tags_(entity_tags(whole)), rows_(rows) {}

  void write(const std::string& name) {
    write_format(out_);
    write_names(out_, names());
    write_entities();
    write_nodes();
    write_elements();
    write_fields(out_, name, whole_, rows_);
  }

 private:
  /// Readers take a group -N without a name for N turned round, where that has one: then -N gets its own.
  RefNames names() const {
    RefNames names = whole_.names;
    for (int d = 1; d <= 3; ++d)
      for (const auto& [ref, tag] : tags_[static_cast<std::size_t>(d)])
        if (ref < 0 && ref > std::numeric_limits<std::int32_t>::min() && !names.all().contains({d, ref}) &&
            names.all().contains({d, std::abs(ref)}))
          names.set(d, ref, names.name(d, ref));
    return names;
  }

  void write_group(std::int32_t ref) {
    out_.size(ref != 0);
    if (ref != 0) out_.integer(ref);
  }

  void write_entities() {
    out_.line("$Entities");
    out_.size(whole_.corners.size());
    for (std::size_t d = 1; d <= 3; ++d) out_.size(tags_[d].size());
    out_.end_row();
    for (std::size_t i = 0; i < whole_.corners.size(); ++i) {
      out_.integer(static_cast<std::int32_t>(i + 1));
      out_.point(whole_.corners[i].place);
      write_group(whole_.corners[i].ref);
      out_.end_row();
    }
    for (std::size_t d = 1; d <= 3; ++d) {
      for (const auto& [ref, tag] : tags_[d]) {
        out_.integer(tag);
        out_.point(whole_.low);
        out_.point(whole_.high);
        write_group(ref);
        out_.size(0);  // entities that bound it
        out_.end_row();
      }
    }
    out_.end_section("$EndEntities");
  }

  /// All in one block, in their order, of the entity of the highest dimension.
  void write_nodes() {
    const std::uint64_t n = whole_.points;
    out_.line("$Nodes");
    for (const std::uint64_t value : {std::uint64_t{n > 0}, n, std::uint64_t{n > 0}, n}) out_.size(value);
    out_.end_row();
    if (n > 0) {
      std::int32_t dimension = 3;
      while (dimension > 0 && tags_[static_cast<std::size_t>(dimension)].empty()) --dimension;
      out_.integer(dimension);
      out_.integer(dimension == 0 ? 1 : tags_[static_cast<std::size_t>(dimension)].begin()->second);
      out_.integer(0);  // not parametric
      out_.size(n);
      out_.end_row();
    }
    rows_({Section::Kind::node_tags});
    rows_({Section::Kind::points});
    out_.end_section("$EndNodes");
  }

  void write_elements() {
    const std::uint64_t n = num_elements(whole_);
    out_.line("$Elements");
    out_.size(whole_.corners.size() + tags_[1].size() + tags_[2].size() + tags_[3].size());
    for (const std::uint64_t value : {n, std::uint64_t{n > 0}, n}) out_.size(value);
    out_.end_row();
    for (const WholeMesh::Corner& corner : whole_.corners) {
      begin_block(0, static_cast<std::int32_t>(number_), gmsh::kPoint, 1);
      out_.size(number_++);
      out_.size(corner.point + 1);
      out_.end_row();
    }
    write_blocks(1, gmsh::kLine, whole_.edges);
    write_blocks(2, gmsh::kTriangle, whole_.triangles);
    write_blocks(3, gmsh::kTetrahedron, whole_.tets);
    out_.end_section("$EndElements");
  }

  void begin_block(std::int32_t dimension, std::int32_t entity, std::int32_t type, std::uint64_t count) {
    out_.integer(dimension);
    out_.integer(entity);
    out_.integer(type);
    out_.size(count);
    out_.end_row();
  }

  void write_blocks(std::size_t dimension, std::int32_t type, const RefCounts& refs) {
    for (const auto& [ref, count] : refs) {
      begin_block(static_cast<std::int32_t>(dimension), tags_[dimension].at(ref), type, count);
      rows_({Section::Kind::elements, dimension + 1, ref, number_});
      number_ += count;
    }
  }

  MshOutput<Out>& out_;
  const WholeMesh& whole_;
  EntityTags tags_;
  Rows& rows_;
  std::uint64_t number_ = 1;  ///< of the next element
};

/// A file of version 2.2: no entities, one row an element whatever its reference. `rows` as in
/// write_fields().
template <class Out, class Rows>
class File2 {
 public:
  File2(MshOutput<Out>& out, const WholeMesh& whole, Rows& rows) : out_(out), whole_(whole), rows_(rows) {}

  void write(const std::string& name) {
    if (std::max(num_elements(whole_), whole_.points) >
        static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
      throw InputError(name, "", "too large for MSH 2.2: write 4.1");
    write_format(out_);
    write_names(out_, whole_.names);
    write_nodes();
    write_elements();
    write_fields(out_, name, whole_, rows_);
  }

 private:
  void write_nodes() {
    out_.line("$Nodes");
    out_.line(std::to_string(whole_.points));
    rows_({Section::Kind::nodes});
    out_.end_section("$EndNodes");
  }

  void write_elements() {
    out_.line("$Elements");
    out_.line(std::to_string(num_elements(whole_)));
    begin(gmsh::kPoint, whole_.corners.size());
    for (const WholeMesh::Corner& corner : whole_.corners) {
      write_element2(out_, number_, corner.ref, static_cast<std::int32_t>(number_), std::array{corner.point});
      ++number_;
    }
    write_elements(1, gmsh::kLine, whole_.num_edges());
    write_elements(2, gmsh::kTriangle, whole_.num_triangles());
    write_elements(3, gmsh::kTetrahedron, whole_.num_tets());
    out_.end_section("$EndElements");
  }

  void write_elements(std::size_t dimension, std::int32_t type, std::uint64_t count) {
    begin(type, count);
    rows_({Section::Kind::elements, dimension + 1, std::nullopt, number_});
    number_ += count;
  }

  void begin(std::int32_t type, std::uint64_t count) {
    if (!out_.is_binary() || count == 0) return;
    out_.integer(type);
    out_.integer(static_cast<std::int32_t>(count));
    out_.integer(2);  // tags
  }

  MshOutput<Out>& out_;
  const WholeMesh& whole_;
  Rows& rows_;
  std::uint64_t number_ = 1;  ///< of the next element
};

template <class Out, class Rows>
void write_file(MshOutput<Out>& out, const std::string& name, const WholeMesh& whole, Rows& rows) {
  out.version() == 4 ? File4(out, whole, rows).write(name) : File2(out, whole, rows).write(name);
}

/// The rows of a mesh or of a part of it, in any section.
template <class Index>
class SectionRows {
 public:
  SectionRows(const WholeMesh& whole, const MeshRows<Index>& rows) : rows_(rows), tags_(entity_tags(whole)) {
    if (whole.options.gmsh_version != 4) return;
    by_ref_[2] = rows_by_ref(rows.edges);
    by_ref_[3] = rows_by_ref(rows.triangles);
    by_ref_[4] = rows_by_ref(rows.tets);
  }

  /// The place of the first one among those of the whole mesh.
  std::uint64_t first(const Section& section) const {
    if (section.kind != Section::Kind::elements) return rows_.first_point;
    if (section.ref) {
      const auto found = by_ref_[section.index].find(*section.ref);
      return found == by_ref_[section.index].end() ? 0 : found->second.first;
    }
    return section.index == 2   ? rows_.edges.first
           : section.index == 3 ? rows_.triangles.first
                                : rows_.tets.first;
  }

  template <class Out>
  void write(MshOutput<Out>& out, const Section& section) const {
    if (section.kind == Section::Kind::elements) {
      if (section.index == 2) write_elements(out, section, rows_.edges);
      if (section.index == 3) write_elements(out, section, rows_.triangles);
      if (section.index == 4) write_elements(out, section, rows_.tets);
      return;
    }
    for (std::size_t p = 0; p < rows_.points.size(); ++p) {
      const std::uint64_t number = rows_.first_point + p + 1;
      if (section.kind == Section::Kind::node_tags || section.kind == Section::Kind::nodes) out.size(number);
      if (section.kind == Section::Kind::points || section.kind == Section::Kind::nodes)
        out.point(rows_.points[p]);
      if (section.kind == Section::Kind::field) {
        out.integer(static_cast<std::int32_t>(number));
        write_values(out, rows_.fields.fields[section.index], p);
      }
      out.end_row();
    }
  }

 private:
  template <class Out, std::size_t N>
  void write_elements(MshOutput<Out>& out, const Section& section, const ElementRows<N, Index>& rows) const {
    std::uint64_t number = section.number + first(section);
    if (!section.ref) {
      for (std::size_t i = 0; i < rows.elements.size(); ++i)
        write_element2(out, number++, rows.refs[i], tags_[N - 1].at(rows.refs[i]), rows.elements[i]);
      return;
    }
    const auto found = by_ref_[N].find(*section.ref);
    if (found == by_ref_[N].end()) return;
    for (const std::uint32_t i : found->second.indices) write_element4(out, number++, rows.elements[i]);
  }

  const MeshRows<Index>& rows_;
  EntityTags tags_;
  std::array<std::map<std::int32_t, RefRows>, 5> by_ref_;  ///< by the number of vertices; of version 4.1
};

// ---- by many

/// A file with gaps.
class Gapped {
 public:
  struct Chunk {
    std::uint64_t position;
    std::string bytes;
  };

  void write(std::string_view text) {
    chunks_.back().bytes.append(text);
    position_ += text.size();
  }
  template <class T>
  void write_value(T value) {
    write({reinterpret_cast<const char*>(&value), sizeof value});
  }
  /// Leaves out so many bytes; returns the position of the first.
  std::uint64_t skip(std::uint64_t bytes) {
    const std::uint64_t first = position_;
    chunks_.push_back({position_ += bytes, {}});
    return first;
  }
  const std::vector<Chunk>& chunks() const { return chunks_; }

 private:
  std::vector<Chunk> chunks_{{0, {}}};
  std::uint64_t position_ = 0;
};

/// What is no row, and where rows go. Positions are those of a file with the names that are known here.
class SectionPlaces {
 public:
  SectionPlaces(const WholeMesh& whole, const std::string& name) : whole_(whole), binary_(is_binary(whole)) {
    MshOutput<Gapped> out(frame_, whole.options);
    write_file(out, name, whole, *this);
  }

  void operator()(Section section) {
    if (binary_) section.row_size = row_size(section);
    section.position = frame_.skip(num_rows(section) * section.row_size);
    sections_.push_back(section);
  }

  const std::vector<Gapped::Chunk>& frame() const { return frame_.chunks(); }
  const std::vector<Section>& sections() const { return sections_; }
  void shift(std::uint64_t by) {
    for (Section& section : sections_) section.position += by;
  }

 private:
  static bool is_binary(const WholeMesh& whole) {
    return whole.options.encoding != WriteOptions::Encoding::ascii;
  }

  std::uint64_t num_rows(const Section& section) const {
    if (section.kind != Section::Kind::elements) return whole_.points;
    const RefCounts& counts = section.index == 2   ? whole_.edges
                              : section.index == 3 ? whole_.triangles
                                                   : whole_.tets;
    return section.ref ? counts.at(*section.ref) : sum_of(counts);
  }
  std::uint64_t row_size(const Section& section) const {
    switch (section.kind) {
      case Section::Kind::node_tags:
        return sizeof(std::uint64_t);
      case Section::Kind::points:
        return sizeof(Point);
      case Section::Kind::nodes:
        return sizeof(std::int32_t) + sizeof(Point);
      case Section::Kind::elements:
        return section.ref ? (1 + section.index) * sizeof(std::uint64_t)
                           : (3 + section.index) * sizeof(std::int32_t);
      case Section::Kind::field:
        return sizeof(std::int32_t) + row_length(whole_.fields.fields[section.index]) * sizeof(double);
    }
    return 0;
  }

  const WholeMesh& whole_;
  bool binary_;
  Gapped frame_;
  std::vector<Section> sections_;
};

class GmshPartWriter final : public PartWriter {
 public:
  GmshPartWriter(PartTarget target, const WholeMesh& whole)
      : whole_(whole), places_(whole, target.name), file_(std::move(target)), out_(file_, whole.options) {}

  /// Only who lays out the file has the names, which stand in front of all rows.
  void set_places(const PartPlaces& places) {
    places_.shift(places.at(0) - places_.sections().front().position);
  }

  PartPlaces write_frame() {
    for (const Gapped::Chunk& chunk : places_.frame()) {
      file_.seek(chunk.position);
      file_.write(chunk.bytes);
    }
    return {places_.sections().front().position};
  }

  void write(const MeshPart& part) override {
    const SectionRows rows(whole_, part);
    for (const Section& section : places_.sections()) {
      file_.seek(section.position + rows.first(section) * section.row_size);
      rows.write(out_, section);
    }
  }
  void finish() override { file_.finish(); }

 private:
  const WholeMesh& whole_;
  SectionPlaces places_;
  FilePart file_;
  MshOutput<FilePart> out_;
};

class GmshTextPart final : public TextPart {
 public:
  GmshTextPart(const WholeMesh& whole, const MeshPart& part)
      : whole_(whole), places_(whole, ""), rows_(whole, part) {}  // gmsh_heads() refuses, by name

  std::string rows(std::size_t section) const override {
    TextInMemory text;
    MshOutput out(text, whole_.options);
    if (section < places_.sections().size()) rows_.write(out, places_.sections()[section]);
    return std::move(text.text);
  }

 private:
  const WholeMesh& whole_;
  SectionPlaces places_;
  SectionRows<std::uint64_t> rows_;
};

}  // namespace

void write_gmsh(const fs::path& path, const MeshView& contents, const WriteOptions& options) {
  check_lengths(contents.mesh, contents.fields);
  AtomicFile file(path);
  WholeMesh whole = describe(contents);
  whole.options = options;
  MshOutput<AtomicFile> out(file, options);
  const MeshRows<std::uint32_t> all = all_rows(contents);
  const SectionRows rows(whole, all);
  const auto write_rows = [&](const Section& section) { rows.write(out, section); };
  write_file(out, path.string(), whole, write_rows);
  file.commit();
}

PartPlaces begin_gmsh_parts(const fs::path& file, const fs::path& name, const WholeMesh& whole) {
  GmshPartWriter writer({file, name.string()}, whole);
  PartPlaces places = writer.write_frame();
  writer.finish();
  return places;
}

std::unique_ptr<PartWriter> open_gmsh_part(PartTarget target, const WholeMesh& whole,
                                           const PartPlaces& places) {
  auto writer = std::make_unique<GmshPartWriter>(std::move(target), whole);
  writer->set_places(places);
  return writer;
}

std::vector<std::string> gmsh_heads(const fs::path& name, const WholeMesh& whole) {
  const SectionPlaces places(whole, name.string());
  std::vector<std::string> heads;
  for (const Gapped::Chunk& chunk : places.frame()) heads.push_back(chunk.bytes);
  return heads;
}

std::unique_ptr<TextPart> open_gmsh_text_part(const WholeMesh& whole, const MeshPart& part) {
  return std::make_unique<GmshTextPart>(whole, part);
}

}  // namespace weft::meshing
