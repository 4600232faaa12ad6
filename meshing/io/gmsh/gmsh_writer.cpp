// Sections of MSH files around the rows, and the rows: written in their order, or by many at their places.
#include "meshing/io/gmsh/gmsh_writer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
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
  MshOutput(Out& out, int version, bool binary) : out_(out), text_(out), version_(version), binary_(binary) {}

  Out& out() { return out_; }
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
void write_format(MshOutput<Out>& out, int version) {
  out.line("$MeshFormat");
  out.line(std::string(version == 4 ? "4.1" : "2.2") + (out.is_binary() ? " 1 8" : " 0 8"));
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

/// Node data; rows.field(i) writes the rows of field `i`.
template <class Out, class Rows>
void write_fields(MshOutput<Out>& out, const std::string& name, const WholeMesh& whole, Rows& rows) {
  const auto& fields = whole.fields.fields;
  if (!fields.empty() && whole.points > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
    throw InputError(name, "", "too many nodes for MSH node data");
  for (std::size_t i = 0; i < fields.size(); ++i) {
    out.line("$NodeData\n1\n" + quoted_name(field_name(whole.fields, i)) + "\n1\n0\n3\n0");
    out.line(std::to_string(row_length(fields[i])) + "\n" + std::to_string(whole.points));
    rows.field(i);
    out.end_section("$EndNodeData");
  }
}

/// A file of version 4.1. `rows` writes rows, or leaves room for them: node_tags(), points(),
/// elements<N>(dimension, ref, number of the first), field(i).
template <class Out, class Rows>
class File4 {
 public:
  File4(MshOutput<Out>& out, const WholeMesh& whole, Rows& rows)
      : out_(out), whole_(whole), tags_(entity_tags(whole)), rows_(rows) {}

  void write(const std::string& name) {
    write_format(out_, 4);
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
    rows_.node_tags();
    rows_.points();
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
    write_blocks<2>(1, gmsh::kLine, whole_.edges);
    write_blocks<3>(2, gmsh::kTriangle, whole_.triangles);
    write_blocks<4>(3, gmsh::kTetrahedron, whole_.tets);
    out_.end_section("$EndElements");
  }

  void begin_block(std::int32_t dimension, std::int32_t entity, std::int32_t type, std::uint64_t count) {
    out_.integer(dimension);
    out_.integer(entity);
    out_.integer(type);
    out_.size(count);
    out_.end_row();
  }

  template <std::size_t N>
  void write_blocks(std::size_t dimension, std::int32_t type, const RefCounts& refs) {
    for (const auto& [ref, count] : refs) {
      begin_block(static_cast<std::int32_t>(dimension), tags_[dimension].at(ref), type, count);
      rows_.template elements<N>(ref, number_);
      number_ += count;
    }
  }

  MshOutput<Out>& out_;
  const WholeMesh& whole_;
  EntityTags tags_;
  Rows& rows_;
  std::uint64_t number_ = 1;  ///< of the next element
};

template <class Out, std::size_t N, class Index>
void write_element(MshOutput<Out>& out, std::uint64_t number, const std::array<Index, N>& nodes) {
  out.size(number);
  for (const Index node : nodes) out.size(std::uint64_t{node} + 1);
  out.end_row();
}

/// The rows of a mesh that lies whole in memory.
class WholeRows {
 public:
  WholeRows(MshOutput<AtomicFile>& out, const MeshView& contents)
      : out_(out),
        mesh_(contents.mesh),
        fields_(contents.fields),
        edges_(indices_by_ref(mesh_.edge_refs)),
        triangles_(indices_by_ref(mesh_.triangle_refs)),
        tets_(indices_by_ref(mesh_.tet_refs)) {}

  void node_tags() {
    for (std::size_t i = 1; i <= mesh_.points.size(); ++i) {
      out_.size(i);
      out_.end_row();
    }
  }
  void points() {
    for (const Point& p : mesh_.points) {
      out_.point(p);
      out_.end_row();
    }
  }
  template <std::size_t N>
  void elements(std::int32_t ref, std::uint64_t number) {
    if constexpr (N == 2) write(mesh_.edges, edges_.at(ref), number);
    if constexpr (N == 3) write(mesh_.triangles, triangles_.at(ref), number);
    if constexpr (N == 4) write(mesh_.tets, tets_.at(ref), number);
  }
  void field(std::size_t i) {
    for (std::size_t p = 0; p < mesh_.points.size(); ++p) {
      out_.integer(static_cast<std::int32_t>(p + 1));
      write_values(out_, fields_.fields[i], p);
      out_.end_row();
    }
  }

 private:
  template <class Elements>
  void write(const Elements& elements, const std::vector<std::uint32_t>& indices, std::uint64_t number) {
    for (const std::uint32_t i : indices) write_element(out_, number++, elements[i]);
  }

  MshOutput<AtomicFile>& out_;
  const MeshData& mesh_;
  const SolutionData& fields_;
  std::map<std::int32_t, std::vector<std::uint32_t>> edges_, triangles_, tets_;
};

/// A file of version 2.2: no entities, one row an element whatever its reference.
class File2 {
 public:
  File2(MshOutput<AtomicFile>& out, const MeshView& contents, const WholeMesh& whole)
      : out_(out), contents_(contents), mesh_(contents.mesh), whole_(whole), tags_(entity_tags(whole)) {}

  void write(const std::string& name) {
    if (std::max(num_elements(whole_), whole_.points) >
        static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
      throw InputError(name, "", "too large for MSH 2.2: write 4.1");
    write_format(out_, 2);
    write_names(out_, whole_.names);
    write_nodes();
    write_elements();
    WholeRows rows(out_, contents_);
    write_fields(out_, name, whole_, rows);
  }

 private:
  void write_nodes() {
    out_.line("$Nodes");
    out_.line(std::to_string(mesh_.points.size()));
    for (std::size_t i = 0; i < mesh_.points.size(); ++i) {
      out_.size(i + 1);
      out_.point(mesh_.points[i]);
      out_.end_row();
    }
    out_.end_section("$EndNodes");
  }

  void write_elements() {
    out_.line("$Elements");
    out_.line(std::to_string(num_elements(whole_)));
    begin(gmsh::kPoint, mesh_.corners.size());
    for (std::size_t i = 0; i < mesh_.corners.size(); ++i) {
      const std::uint32_t corner = mesh_.corners[i];
      write_element(gmsh::kPoint, mesh_.point_refs[corner], static_cast<std::int32_t>(i + 1),
                    std::array<std::uint32_t, 1>{corner});
    }
    write_elements(gmsh::kLine, mesh_.edges, mesh_.edge_refs, tags_[1]);
    write_elements(gmsh::kTriangle, mesh_.triangles, mesh_.triangle_refs, tags_[2]);
    write_elements(gmsh::kTetrahedron, mesh_.tets, mesh_.tet_refs, tags_[3]);
    out_.end_section("$EndElements");
  }

  template <class Elements>
  void write_elements(std::int32_t type, const Elements& elements, const std::vector<std::int32_t>& refs,
                      const std::map<std::int32_t, std::int32_t>& tags) {
    begin(type, elements.size());
    for (std::size_t i = 0; i < elements.size(); ++i)
      write_element(type, refs[i], tags.at(refs[i]), elements[i]);
  }

  void begin(std::int32_t type, std::size_t count) {
    if (!out_.is_binary() || count == 0) return;
    out_.integer(type);
    out_.integer(static_cast<std::int32_t>(count));
    out_.integer(2);  // tags
  }

  template <std::size_t N>
  void write_element(std::int32_t type, std::int32_t ref, std::int32_t tag,
                     const std::array<std::uint32_t, N>& nodes) {
    out_.size(++last_);
    if (!out_.is_binary()) {
      out_.integer(type);
      out_.integer(2);
    }
    out_.integer(ref);
    out_.integer(tag);
    for (const std::uint32_t node : nodes) out_.size(std::uint64_t{node} + 1);
    out_.end_row();
  }

  MshOutput<AtomicFile>& out_;
  const MeshView& contents_;
  const MeshData& mesh_;
  const WholeMesh& whole_;
  EntityTags tags_;
  std::uint64_t last_ = 0;  ///< number of the last element
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

/// Elements of one reference.
struct Block {
  std::uint64_t position, number;  ///< of the first
};

/// Room for the rows, and where it is. Positions are those of a file with the names that are known here.
class Places {
 public:
  explicit Places(const WholeMesh& whole, const std::string& name) : whole_(whole) {
    MshOutput<Gapped> out(frame_, 4, true);
    File4(out, whole, *this).write(name);
  }

  static constexpr std::uint64_t kTag = sizeof(std::uint64_t);
  template <std::size_t N>
  static constexpr std::uint64_t kElement = (1 + N) * sizeof(std::uint64_t);
  static std::uint64_t field_row(const Field& field) {
    return sizeof(std::int32_t) + row_length(field) * sizeof(double);
  }

  void node_tags() { tags_ = frame_.skip(whole_.points * kTag); }
  void points() { points_ = frame_.skip(whole_.points * sizeof(Point)); }
  template <std::size_t N>
  void elements(std::int32_t ref, std::uint64_t number) {
    const RefCounts& counts = N == 2 ? whole_.edges : N == 3 ? whole_.triangles : whole_.tets;
    blocks_[N][ref] = {frame_.skip(counts.at(ref) * kElement<N>), number};
  }
  void field(std::size_t i) {
    fields_.push_back(frame_.skip(whole_.points * field_row(whole_.fields.fields[i])));
  }

  const Gapped& frame() const { return frame_; }
  /// The position of the first row.
  std::uint64_t first() const { return tags_; }
  void shift(std::uint64_t by) {
    tags_ += by;
    points_ += by;
    for (auto& blocks : blocks_)
      for (auto& [ref, block] : blocks) block.position += by;
    for (std::uint64_t& field : fields_) field += by;
  }
  std::uint64_t of_tag(std::uint64_t point) const { return tags_ + point * kTag; }
  std::uint64_t of_point(std::uint64_t point) const { return points_ + point * sizeof(Point); }
  template <std::size_t N>
  const Block& of_block(std::int32_t ref) const {
    return blocks_[N].at(ref);
  }
  std::uint64_t of_field(std::size_t i, std::uint64_t point) const {
    return fields_[i] + point * field_row(whole_.fields.fields[i]);
  }

 private:
  const WholeMesh& whole_;
  Gapped frame_;
  std::uint64_t tags_ = 0, points_ = 0;
  std::array<std::map<std::int32_t, Block>, 5> blocks_;  ///< by the number of vertices of the elements
  std::vector<std::uint64_t> fields_;
};

class GmshPartWriter final : public PartWriter {
 public:
  GmshPartWriter(PartTarget target, const WholeMesh& whole)
      : places_(whole, target.name), file_(std::move(target)), out_(file_, 4, true) {}

  /// Only who lays out the file has the names, which stand in front of all rows.
  void set_places(const PartPlaces& places) { places_.shift(places.at(0) - places_.first()); }

  PartPlaces write_frame() {
    for (const Gapped::Chunk& chunk : places_.frame().chunks()) {
      file_.seek(chunk.position);
      file_.write(chunk.bytes);
    }
    return {places_.first()};
  }

  void write(const MeshPart& part) override {
    file_.seek(places_.of_tag(part.first_point));
    for (std::uint64_t i = 1; i <= part.points.size(); ++i) out_.size(part.first_point + i);
    file_.seek(places_.of_point(part.first_point));
    for (const Point& p : part.points) out_.point(p);
    write_elements(part.edges);
    write_elements(part.triangles);
    write_elements(part.tets);
    for (std::size_t i = 0; i < part.fields.fields.size(); ++i) {
      file_.seek(places_.of_field(i, part.first_point));
      for (std::size_t p = 0; p < part.points.size(); ++p) {
        out_.integer(static_cast<std::int32_t>(part.first_point + p + 1));
        write_values(out_, part.fields.fields[i], p);
      }
    }
  }
  void finish() override { file_.finish(); }

 private:
  template <std::size_t N>
  void write_elements(const ElementRows<N>& rows) {
    for (const auto& [ref, of_ref] : rows_by_ref(rows)) {
      const Block& block = places_.of_block<N>(ref);
      file_.seek(block.position + of_ref.first * Places::kElement<N>);
      std::uint64_t number = block.number + of_ref.first;
      for (const std::uint32_t i : of_ref.indices) write_element(out_, number++, rows.elements[i]);
    }
  }

  Places places_;
  FilePart file_;
  MshOutput<FilePart> out_;
};

}  // namespace

void write_gmsh(const fs::path& path, const MeshView& contents, const WriteOptions& options) {
  check_lengths(contents.mesh, contents.fields);
  AtomicFile file(path);
  const WholeMesh whole = describe(contents);
  MshOutput<AtomicFile> out(file, options.gmsh_version, options.encoding != WriteOptions::Encoding::ascii);
  if (options.gmsh_version == 4) {
    WholeRows rows(out, contents);
    File4(out, whole, rows).write(path.string());
  } else {
    File2(out, contents, whole).write(path.string());
  }
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

}  // namespace weft::meshing
